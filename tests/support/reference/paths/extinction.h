// Collisions of rays in a heterogeneous medium by delta tracking (Woodcock 1965): tentative collisions are drawn from
// an extinction that is nowhere exceeded, and each is real with the share of the true extinction there. No steps, no
// bias. Each cube between eight voxels has a bound of its own, so empty space costs nothing.
//
// Space is physical: voxel positions times the spacing, in smallest voxel edges.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "counter_random.h"
#include "path_scene.h"
#include "reference/field.h"
#include "solids.h"

namespace gicube::reference::paths {

// A ray between two scatterings. A scattered ray passes reflecting materials while it moves out of them, against their
// gradient; one that a routine has answered passes materials with routines until it has been outside of them.
struct Flight {
  Vec3 origin;
  Vec3 direction;  // unit
  bool scattered = false;
  bool at_surface = false;
  bool inside = false;  // a solid with a sharp surface: of glass
};

struct Collision {
  Vec3 position;
  double distance = 0;
  int tag = 0;
  Vec3 normal{};  // physical unit vector, out of the solid, of a sharp surface; zero otherwise
};

class Extinction {
 public:
  // Both must outlive it.
  Extinction(const PathScene& scene, const Field& field);

  // The first collision that is nearer than `limit`; none if the ray leaves the volume, or what cut planes keep,
  // before.
  std::optional<Collision> collide(Flight flight, double limit, CounterRandom& random) const;
  // An unbiased estimate, 0..1, of what passes along `distance` (ratio tracking, Novak et al. 2014).
  double transmittance(Flight flight, double distance, CounterRandom& random) const;

  // Of unit length or shorter, towards where the value grows; zero where no material's scattering depends on it.
  Vec3 gradient(Vec3 position) const;

  Vec3 voxel_of(Vec3 p) const { return {p.x / spacing_.x, p.y / spacing_.y, p.z / spacing_.z}; }
  Vec3 place_of(Vec3 voxel) const { return {voxel.x * spacing_.x, voxel.y * spacing_.y, voxel.z * spacing_.z}; }

 private:
  struct Site {
    double extinction = 0;
    int tag = 0;
  };
  Site site(Vec3 position) const;
  double bound_of_cube(const std::array<int, 3>& low, const std::vector<double>& values) const;
  double extinction_of(double opacity) const;
  // What a tentative collision there is worth to this ray, 0..1 of `bound`.
  double real_share(Flight& flight, Vec3 position, double bound, int& tag) const;
  template <typename Visit>
  void track(Flight& flight, double limit, CounterRandom& random, const Visit& visit) const;

  std::optional<Collision> surface(const Flight& flight, double limit) const;

  const PathScene& scene_;
  const Field& field_;
  Solids solids_;
  Vec3 spacing_;
  std::array<int, 3> cubes_{};
  std::vector<double> bounds_;
  bool any_ = false;                             // medium: something that is not a sharp solid
  std::vector<std::array<float, 3>> gradients_;  // of the voxels
};

}  // namespace gicube::reference::paths
