#include "meshes/scene_polygons.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "gicube/scene/error.h"
#include "meshes/triangulate.h"
#include "scene/common/checks.h"

namespace gicube::samples {
namespace {

class Taker {
 public:
  explicit Taker(const Scene& scene) : scene_(scene) {}

  void visit(Node& node, const Affine& parent, const std::string& inherited) {
    const Affine map = compose(parent, map_of(node.transforms));
    const std::string material = node.material.empty() ? inherited : node.material;
    if (const auto* shape = std::get_if<Shape>(&node.content)) {
      try {
        take(node, *shape, map, material);
      } catch (const FileError&) {
        throw;
      } catch (const InputError& error) {
        throw InputError(within("node[" + node.name + "]", error));
      }
    }
    for (Node& child : node.children) visit(child, map, material);
  }

  std::vector<PolygonSurface> surfaces;

 private:
  void take(Node& node, const Shape& shape, const Affine& map, const std::string& material) {
    const auto found = std::ranges::find(scene_.materials, material, &SceneMaterial::name);
    if (found == scene_.materials.end()) throw InputError("material", "a material of the scene", material);
    if (found->look && !look_as<SolidLook>(*found)) return;  // a medium
    const auto* box = std::get_if<BoxShape>(&shape);
    const auto* file = std::get_if<MeshShape>(&shape);
    if (!file && (!box || box->rounding > 0)) {
      throw InputError("shape", "a mesh or a box without rounding, of a solid", "another one");
    }
    const Bsdf bsdf = found->optics.bsdf;
    if (bsdf != Bsdf::kDiffuse && !(bsdf == Bsdf::kNone && found->optics.scattering == 0)) {
      throw InputError("material.bsdf", "diffuse", "another one");
    }
    if (const auto* look = look_as<SolidLook>(*found); look && look->opacity < 1) {
      throw InputError("material.opacity", "1", std::to_string(look->opacity));
    }
    PolygonSurface surface{node.name, box ? mesh_of(*box) : file->mesh ? *file->mesh : read_mesh(file->file)};
    for (Vec3& point : surface.mesh.points) point = map.point(point);
    for (std::size_t c = 0; c < 3; ++c) {
      surface.albedo[c] = found->optics.scattering * found->scattering_colour[c];
      surface.emission[c] = found->emission * found->emission_colour[c];
    }
    surfaces.push_back(std::move(surface));
    node.content = Group{};
  }

  const Scene& scene_;
};

}  // namespace

std::vector<PolygonSurface> take_polygons(Scene& scene) {
  if (!scene.world) throw InputError("world", "one with solids", "none");
  Taker taker(scene);
  taker.visit(scene.world->root, {}, "");
  if (taker.surfaces.empty()) throw InputError("world.node", "at least one mesh or box of a solid", "none");
  return std::move(taker.surfaces);
}

// By places: sides of a box have corners of their own.
std::vector<Mesh> meshes_of(const std::vector<PolygonSurface>& surfaces) {
  std::vector<Mesh> out;
  for (const PolygonSurface& surface : surfaces) out.push_back(surface.mesh);
  return out;
}

bool is_closed(const Mesh& mesh) {
  const auto before = [](const Vec3& a, const Vec3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); };
  std::map<Vec3, std::size_t, decltype(before)> places(before);
  std::map<std::pair<std::size_t, std::size_t>, int> open;  // edges, by how much oftener they are gone along than back
  for (const auto& triangle : mesh.triangles) {
    std::array<std::size_t, 3> corner{};
    for (std::size_t i = 0; i < 3; ++i)
      corner[i] = places.try_emplace(mesh.points[triangle[i]], places.size()).first->second;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t a = corner[i], b = corner[(i + 1) % 3];
      open[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  return std::ranges::all_of(open, [](const auto& edge) { return edge.second == 0; });
}

}  // namespace gicube::samples
