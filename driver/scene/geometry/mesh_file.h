// The two mesh formats of gicube/scene/mesh.h.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "gicube/scene/mesh.h"

namespace gicube::scene {

// read_mesh() for text or bytes in memory; `name` stands for the file in messages.
Mesh parse_obj(std::string_view text, const std::filesystem::path& name);
Mesh parse_ply(std::string_view bytes, const std::filesystem::path& name);

// Adds a polygon as a fan of triangles around its first corner. False, and adds nothing: the mesh had more than
// kMaxTriangles then.
bool add_fan(std::span<const std::uint32_t> corners, Mesh& mesh);

}  // namespace gicube::scene
