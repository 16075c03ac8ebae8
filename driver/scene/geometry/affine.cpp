#include "gicube/scene/affine.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

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

std::array<Stretch, 3> principal_stretches(const Affine& map) {
  // The eigenvectors of M M^T by Jacobi's rotations (W. H. Press et al., Numerical Recipes, section 11.1).
  constexpr int kSweeps = 20;  // chosen: it converges quadratically, 6 do
  std::array<std::array<double, 3>, 3> m{}, v{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) m[i][k] = dot(map.rows[i], map.rows[k]);
  }
  const double size = m[0][0] + m[1][1] + m[2][2];
  for (int sweep = 0; sweep < kSweeps && std::abs(m[0][1]) + std::abs(m[0][2]) + std::abs(m[1][2]) > 1e-15 * size;
       ++sweep) {
    for (const auto& [p, q] : {std::pair<std::size_t, std::size_t>{0, 1}, {0, 2}, {1, 2}}) {
      if (m[p][q] == 0) continue;
      const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
      const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1));
      const double c = 1 / std::hypot(t, 1), s = t * c;
      const auto turn = [c, s](double& a, double& b) { std::tie(a, b) = std::pair(c * a - s * b, s * a + c * b); };
      for (std::size_t k = 0; k < 3; ++k) turn(m[k][p], m[k][q]);
      for (std::size_t k = 0; k < 3; ++k) turn(m[p][k], m[q][k]);
      for (std::size_t k = 0; k < 3; ++k) turn(v[k][p], v[k][q]);
    }
  }
  std::array<Stretch, 3> found;
  for (std::size_t i = 0; i < 3; ++i) {
    found[i] = {{v[0][i], v[1][i], v[2][i]}, std::sqrt(std::max(m[i][i], 0.0))};
  }
  std::ranges::sort(found, {}, &Stretch::factor);
  return found;
}

double min_stretch(const Affine& map) { return principal_stretches(map).front().factor; }

}  // namespace gicube::scene
