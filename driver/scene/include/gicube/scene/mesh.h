// Triangle meshes, in memory or from Wavefront OBJ and PLY files.
//
//   .obj   `v`, `vt` and `f` statements (also v/vt/vn and negative indices); normals, groups and materials are ignored
//   .ply   ascii, binary_little_endian, binary_big_endian 1.0: element vertex with x y z, element face with the list
//          vertex_indices or vertex_index; other elements and properties are skipped
//
// Polygons become fans of triangles around their first corner, which is correct for convex polygons.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "gicube/scene/error.h"
#include "gicube/vector.h"

namespace gicube::scene {

struct Mesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of points, counter-clockwise as seen from outside
  // Texture coordinates u, v, and their indices for each triangle. Both are empty unless all corners of all faces have
  // some (.obj).
  std::vector<std::array<double, 2>> texture{};
  std::vector<std::array<std::uint32_t, 3>> texture_triangles{};
};

constexpr std::uintmax_t kMaxMeshMib = 512;      // chosen: of the file
constexpr std::size_t kMaxTriangles = 8u << 20;  // chosen: far finer than any board's voxels

// The extension gives the format. Memory is allocated only as far as the file's size justifies. Throws InputError: the
// file does not exist, is too large or cannot be read. Throws FileError: it is truncated or damaged, names missing
// points, has no triangle, or too many.
GICUBE_API Mesh read_mesh(const std::filesystem::path& path);

}  // namespace gicube::scene
