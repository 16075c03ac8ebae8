#include "scene/geometry/mesh_file.h"

#include <string>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"

namespace gicube::scene {

bool add_fan(std::span<const std::uint32_t> corners, Mesh& mesh) {
  if (mesh.triangles.size() + corners.size() > kMaxTriangles + 2) return false;
  for (std::size_t i = 2; i < corners.size(); ++i) {
    mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
  }
  return true;
}

Mesh read_mesh(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  if (extension != ".obj" && extension != ".ply") {
    throw FileError(path, "name", "an ending .obj or .ply", in_quotes(extension));
  }
  const std::string text = read_text(path, "a mesh", kMaxMeshMib);
  return extension == ".obj" ? parse_obj(text, path) : parse_ply(text, path);
}

}  // namespace gicube::scene
