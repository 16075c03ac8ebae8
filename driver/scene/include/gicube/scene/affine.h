// Affine maps of space: where a solid of the scenegraph lies in its world.
#pragma once

#include <array>

#include "gicube/export.h"
#include "gicube/vector.h"

namespace gicube::scene {

// p -> linear p + offset.
struct Affine {
  std::array<Vec3, 3> rows{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
  Vec3 offset{};

  Vec3 vector(Vec3 v) const { return {dot(rows[0], v), dot(rows[1], v), dot(rows[2], v)}; }
  Vec3 point(Vec3 p) const { return vector(p) + offset; }
  // The transposed linear part: of the inverse map, it takes gradients along.
  Vec3 transposed(Vec3 v) const { return v.x * rows[0] + v.y * rows[1] + v.z * rows[2]; }
};

// First `inner`, then `outer`.
GICUBE_API Affine compose(const Affine& outer, const Affine& inner);
GICUBE_API Affine translation(Vec3 by);
// Counter-clockwise as seen against `axis` (any length but 0).
GICUBE_API Affine rotation(Vec3 axis, double degrees);
GICUBE_API Affine scaling(Vec3 factors);

GICUBE_API double determinant(const Affine& map);
// Its determinant must not be 0.
GICUBE_API Affine inverse(const Affine& map);
// A map takes the unit sphere to an ellipsoid: the half-axes of that, directions of unit length, shortest first.
struct Stretch {
  Vec3 direction;
  double factor = 0;  // the linear part's singular value
};
GICUBE_API std::array<Stretch, 3> principal_stretches(const Affine& map);
// The factor by which the shortest-grown vector grows.
GICUBE_API double min_stretch(const Affine& map);

}  // namespace gicube::scene
