// Reads triangle meshes from Wavefront OBJ and from PLY files.
//
//   .obj   `v` and `f` statements (also v/vt/vn and negative indices); normals, textures, groups and materials are ignored
//   .ply   ascii, binary_little_endian, binary_big_endian 1.0: element vertex with x y z, element face with the list
//          vertex_indices or vertex_index; other elements and properties are skipped
//
// Polygons become fans of triangles around their first corner, which is right for convex ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>

#include "scene/formats/file_error.h"
#include "scene/geometry/mesh.h"

namespace gicube::samples {

constexpr std::uintmax_t kMaxMeshMib = 512;      // chosen: of the file
constexpr std::size_t kMaxTriangles = 8u << 20;  // chosen: far finer than any board's voxels

// By the extension. Memory is taken only as far as the file's real size can back it. Throws InputError: the file is not
// there, is too large or can't be read. Throws FileError: it is truncated or damaged, names points that it does not have, holds no triangle, or too many.
Mesh read_mesh(const std::filesystem::path& path);

// The same for text or bytes in memory; `name` stands for the file in messages.
Mesh parse_obj(std::string_view text, const std::filesystem::path& name);
Mesh parse_ply(std::string_view bytes, const std::filesystem::path& name);

// Adds a polygon as a fan of triangles around its first corner. False, and adds nothing: the mesh had more than kMaxTriangles then.
bool add_fan(std::span<const std::uint32_t> corners, Mesh& mesh);

}  // namespace gicube::samples
