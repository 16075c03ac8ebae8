// Crossings of rays with triangle meshes. Embree finds the triangles; positions are computed from their corners in
// double precision.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gicube/scene/mesh.h"
#include "gicube/vector.h"
#include "scene/names.h"

namespace gicube::samples {

struct Crossing {
  double distance = 0;  // along the ray
  std::uint32_t mesh = 0, triangle = 0;
  bool from_outside = false;  // against the triangle's normal
};

// All meshes are in one space. A triangle may be hit or missed wrongly if the ray passes within 2^-23 of its
// coordinates.
class MeshCaster {
 public:
  explicit MeshCaster(std::vector<Mesh> meshes);
  ~MeshCaster();

  // All crossings in front of `from`, nearest first; `direction` of unit length. A ray through a common edge or corner
  // of triangles of one mesh crosses the surface once there.
  void find(Vec3 from, Vec3 direction, std::vector<Crossing>& found) const;
  // Only crossings farther away than 1e-6: a ray that begins on a triangle does not cross it.
  void ahead(Vec3 from, Vec3 direction, std::vector<Crossing>& found) const;
  // The nearest crossing of ahead().
  std::optional<Crossing> first(Vec3 from, Vec3 direction) const;
  // Whether there is a crossing nearer than `distance` by more than 1e-6.
  bool blocked(Vec3 from, Vec3 direction, double distance) const;
  // Only the triangles, each a mesh and its triangle, in any order.
  void meet(Vec3 from, Vec3 direction, std::vector<std::pair<std::uint32_t, std::uint32_t>>& found) const;
  // Unit normal, to the side from which the corners are counter-clockwise; zero for a triangle without area.
  Vec3 normal(const Crossing& crossing) const;
  const std::vector<Mesh>& meshes() const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace gicube::samples
