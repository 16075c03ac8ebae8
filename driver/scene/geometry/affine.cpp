#include "gicube/scene/affine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gicube::scene {

Affine compose(const Affine& outer, const Affine& inner) {
  Affine result;
  for (std::size_t i = 0; i < 3; ++i) result.rows[i] = inner.transposed(outer.rows[i]);
  result.offset = outer.point(inner.offset);
  return result;
}

Affine translation(Vec3 by) { return {.offset = by}; }

// Rodrigues' formula.
Affine rotation(Vec3 axis, double degrees) {
  const Vec3 k = normalise(axis);
  const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle), d = 1 - c;
  return {.rows = {Vec3{c + d * k.x * k.x, d * k.x * k.y - s * k.z, d * k.x * k.z + s * k.y},
                   Vec3{d * k.y * k.x + s * k.z, c + d * k.y * k.y, d * k.y * k.z - s * k.x},
                   Vec3{d * k.z * k.x - s * k.y, d * k.z * k.y + s * k.x, c + d * k.z * k.z}}};
}

Affine scaling(Vec3 factors) { return {.rows = {Vec3{factors.x, 0, 0}, Vec3{0, factors.y, 0}, Vec3{0, 0, factors.z}}}; }

double determinant(const Affine& map) { return dot(map.rows[0], cross(map.rows[1], map.rows[2])); }

Affine inverse(const Affine& map) {
  const double scale = 1 / determinant(map);
  const Vec3 a = scale * cross(map.rows[1], map.rows[2]), b = scale * cross(map.rows[2], map.rows[0]),
             c = scale * cross(map.rows[0], map.rows[1]);
  Affine result;  // the cross products are the columns
  result.rows = {Vec3{a.x, b.x, c.x}, Vec3{a.y, b.y, c.y}, Vec3{a.z, b.z, c.z}};
  result.offset = -1 * result.vector(map.offset);
  return result;
}

double min_stretch(const Affine& map) {
  // The least eigenvalue of M M^T in closed form (O. K. Smith, Eigenvalues of a symmetric 3 x 3 matrix, CACM 1961).
  const auto& [p, q, r] = map.rows;
  const double xx = dot(p, p), yy = dot(q, q), zz = dot(r, r), xy = dot(p, q), xz = dot(p, r), yz = dot(q, r);
  const double mean = (xx + yy + zz) / 3, a = xx - mean, b = yy - mean, c = zz - mean;
  const double spread = std::sqrt((a * a + b * b + c * c + 2 * (xy * xy + xz * xz + yz * yz)) / 6);
  if (spread <= 1e-12 * mean) return std::sqrt(mean);
  const double det = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const double angle = std::acos(std::clamp(det / (2 * spread * spread * spread), -1.0, 1.0)) / 3;
  const double least = mean + 2 * spread * std::cos(angle + 2 * std::numbers::pi / 3);
  return std::sqrt(std::max(least, 0.0));
}

}  // namespace gicube::scene
