// Where a ray crosses triangle meshes. Embree finds the triangles; the places are computed from their corners in double
// precision.
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

// Meshes are in one space. A triangle that a ray misses by less than 2^-23 of its coordinates may count as met, and the
// reverse.
class MeshCaster {
 public:
  explicit MeshCaster(std::vector<Mesh> meshes);
  ~MeshCaster();

  // All crossings in front of `from`, nearest first; `direction` of unit length. A ray through a common edge or corner
  // of triangles of one mesh crosses the surface once there.
  void find(Vec3 from, Vec3 direction, std::vector<Crossing>& found) const;
  // Those further away than 1e-6: a ray that begins on a triangle does not meet it.
  void ahead(Vec3 from, Vec3 direction, std::vector<Crossing>& found) const;
  // The nearest of those.
  std::optional<Crossing> first(Vec3 from, Vec3 direction) const;
  // Whether there is one nearer than `distance`, where another triangle may be that is not counted.
  bool blocked(Vec3 from, Vec3 direction, double distance) const;
  // Those triangles alone, each a mesh and its triangle, in no order.
  void meet(Vec3 from, Vec3 direction, std::vector<std::pair<std::uint32_t, std::uint32_t>>& found) const;
  // Unit normal, to the side from which the corners are counter-clockwise; zero for a triangle without area.
  Vec3 normal(const Crossing& crossing) const;
  const std::vector<Mesh>& meshes() const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace gicube::samples
