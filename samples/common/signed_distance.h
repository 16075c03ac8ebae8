// Signed distances of simple solids (negative inside) and their gradients: unit vectors that point away from the solid.
#pragma once

#include <algorithm>
#include <cmath>

#include "gicube/vector.h"

namespace gicube::samples {

struct Distance {
  double distance = 0;
  Vec3 away;  // zero where no direction is nearest
};

inline Distance away_from(Vec3 offset, double radius) {
  const double norm = length(offset);
  return {norm - radius, norm > 0 ? (1 / norm) * offset : Vec3{}};
}

inline Distance sphere_distance(Vec3 p, Vec3 centre, double radius) { return away_from(p - centre, radius); }

// All points within `radius` of the line from `a` to `b`.
inline Distance capsule_distance(Vec3 p, Vec3 a, Vec3 b, double radius) {
  const Vec3 axis = b - a;
  const double along = std::clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
  return away_from(p - (a + along * axis), radius);
}

// An axis-parallel box whose edges and corners are rounded off by `rounding`.
inline Distance box_distance(Vec3 p, Vec3 low, Vec3 high, double rounding) {
  const Vec3 offset = p - 0.5 * (low + high);
  const Vec3 half = 0.5 * (high - low) - Vec3{rounding, rounding, rounding};
  const Vec3 side{std::copysign(1.0, offset.x), std::copysign(1.0, offset.y), std::copysign(1.0, offset.z)};
  const Vec3 beyond{std::abs(offset.x) - half.x, std::abs(offset.y) - half.y, std::abs(offset.z) - half.z};
  const double most = std::max({beyond.x, beyond.y, beyond.z});
  if (most <= 0) {
    const Vec3 axis = beyond.x == most   ? Vec3{side.x, 0, 0}
                      : beyond.y == most ? Vec3{0, side.y, 0}
                                         : Vec3{0, 0, side.z};
    return {most - rounding, axis};
  }
  const Vec3 outside{std::max(beyond.x, 0.0), std::max(beyond.y, 0.0), std::max(beyond.z, 0.0)};
  const double norm = length(outside);
  return {norm - rounding, (1 / norm) * Vec3{side.x * outside.x, side.y * outside.y, side.z * outside.z}};
}

}  // namespace gicube::samples
