// Signed distances of simple solids (negative inside) and their gradients: unit vectors that point away from the solid.
// Closed forms as in I. Quilez, "Distance functions". All are exact, except for the bound of the ellipsoid.
#pragma once

#include <algorithm>
#include <cmath>

#include "gicube/scene/shape.h"
#include "scene/common/checks.h"

namespace gicube::scene {

inline Distance away_from(Vec3 offset, double radius) { return {length(offset) - radius, unit_or_zero(offset)}; }

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

// A rectangle |a| <= half_a, |b| <= half_b with rounded corners, in the plane of two unit vectors that are across each
// other: `a` and `b` are the point's coordinates along them. For solids of revolution.
inline Distance rectangle_distance(double a, double b, double half_a, double half_b, double rounding, Vec3 along_a,
                                   Vec3 along_b) {
  const double beyond_a = std::abs(a) - (half_a - rounding), beyond_b = std::abs(b) - (half_b - rounding);
  const Vec3 out_a = std::copysign(1.0, a) * along_a, out_b = std::copysign(1.0, b) * along_b;
  const double most = std::max(beyond_a, beyond_b);
  if (most <= 0) return {most - rounding, beyond_a == most ? out_a : out_b};
  const double over_a = std::max(beyond_a, 0.0), over_b = std::max(beyond_b, 0.0), norm = std::hypot(over_a, over_b);
  return {norm - rounding, (over_a / norm) * out_a + (over_b / norm) * out_b};
}

// The unit vector from the z axis to `p`; zero on the axis.
inline Vec3 from_axis(Vec3 p) {
  const double radius = std::hypot(p.x, p.y);
  return radius > 0 ? Vec3{p.x / radius, p.y / radius, 0} : Vec3{};
}

// Around the z axis: the tube's centre runs at `radius` from it.
inline Distance torus_distance(Vec3 p, double radius, double tube) {
  const Vec3 out = from_axis(p);
  const double across = std::hypot(p.x, p.y) - radius, norm = std::hypot(across, p.z);
  return {norm - tube, norm > 0 ? (1 / norm) * (across * out + Vec3{0, 0, p.z}) : Vec3{}};
}

// Along the z axis, |z| <= height / 2, between the radii `inner` (0: not hollow) and `outer`; edges are rounded off.
inline Distance cylinder_distance(Vec3 p, double inner, double outer, double height, double rounding) {
  const double middle = inner > 0 ? 0.5 * (inner + outer) : 0, half = outer - middle;
  return rectangle_distance(std::hypot(p.x, p.y) - middle, p.z, half, 0.5 * height, rounding, from_axis(p), {0, 0, 1});
}

// Zero on the ellipsoid, and elsewhere nearer to zero than the distance; `away` is its gradient, at most 1 long.
inline Distance ellipsoid_bound(Vec3 p, Vec3 centre, Vec3 radii) {
  const Vec3 offset = p - centre;
  const Vec3 scaled{offset.x / radii.x, offset.y / radii.y, offset.z / radii.z};
  const double norm = length(scaled), least = std::min({radii.x, radii.y, radii.z});
  if (!(norm > 0)) return {-least, {}};
  return {least * (norm - 1), (least / norm) * Vec3{scaled.x / radii.x, scaled.y / radii.y, scaled.z / radii.z}};
}

// A stylised human head with neck: ellipsoids, spheres and a capsule that flow into each other. The face looks along
// -y, the crown along +z; within |x| < 0.65, -0.9 < y < 0.85, -1.1 < z < 0.9.
Distance head_bound(Vec3 p);

}  // namespace gicube::scene
