// A solid's field as seen from the voxels it is placed in.
#pragma once

#include <array>
#include <optional>

#include "gicube/scene/voxeliser.h"

namespace gicube::scene {

class PlacedField {
 public:
  // `placed` must outlive this object.
  explicit PlacedField(const PlacedSolid& placed);

  const PlacedSolid& solid() const { return *solid_; }

  // Lengths below are voxels.

  // A bound whose absolute value never exceeds that of the distance.
  double bound(Vec3 p) const { return stretches_.front().factor * solid_->field(to_local_.point(p)).distance; }
  // The distance. Similarity maps scale distances by one factor. Under other maps the nearest point is searched if it
  // may be nearer than `reach`; otherwise the result is at least that far from 0. For a ball flattened to 0.8 voxels,
  // the error is at most 0.002 voxels within one voxel of the surface, and 0.02 beyond (placed_field_test).
  Distance distance(Vec3 p, double reach = kNearVoxels) const;

 private:
  // To first order, from the field's value at a point: exact for similarity maps of exact fields.
  Distance first_order(const Distance& local) const;
  enum class Space { kVoxels, kOwn };
  std::optional<Vec3> onto_surface(Vec3 q, Space space) const;
  std::optional<Vec3> onto_surface_near(Vec3 p, Vec3 q) const;
  double along(Vec3 p, Vec3 direction, double factor, double at_p, double limit) const;
  void slide_towards(Vec3 p, Vec3& q) const;

  const PlacedSolid* solid_;
  Affine to_local_;
  std::array<Stretch, 3> stretches_;
  bool is_similar_;
};

}  // namespace gicube::scene
