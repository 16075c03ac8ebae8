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
  // Applies the transposed linear part. That of the inverse map transforms gradients.
  Vec3 transposed(Vec3 v) const { return v.x * rows[0] + v.y * rows[1] + v.z * rows[2]; }
};

// First `inner`, then `outer`.
GICUBE_API Affine compose(const Affine& outer, const Affine& inner);
GICUBE_API Affine translation(Vec3 by);
// Counter-clockwise as seen against `axis`, whose length must not be 0.
GICUBE_API Affine rotation(Vec3 axis, double degrees);
GICUBE_API Affine scaling(Vec3 factors);

GICUBE_API double determinant(const Affine& map);
// Its determinant must not be 0.
GICUBE_API Affine inverse(const Affine& map);
// A half-axis of the ellipsoid that a map makes of the unit sphere.
struct Stretch {
  Vec3 direction;     // of unit length
  double factor = 0;  // its length, a singular value of the linear part
};
// The shortest first.
GICUBE_API std::array<Stretch, 3> principal_stretches(const Affine& map);
// The least factor by which the map lengthens a vector.
GICUBE_API double min_stretch(const Affine& map);

}  // namespace gicube::scene
