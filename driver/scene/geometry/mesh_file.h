// The two mesh formats of gicube/scene/mesh.h.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "gicube/scene/mesh.h"

namespace gicube::scene {

// read_mesh() for text or bytes in memory; messages name `name` as the file.
Mesh parse_obj(std::string_view text, const std::filesystem::path& name);
Mesh parse_ply(std::string_view bytes, const std::filesystem::path& name);

// Adds a polygon as a fan of triangles around its first corner. False: the mesh would exceed kMaxTriangles, and nothing
// is added.
bool add_fan(std::span<const std::uint32_t> corners, Mesh& mesh);

}  // namespace gicube::scene
