// Vectors of three doubles, for lighting rays and scattering.
#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace gicube::emu {

using Vector = std::array<double, 3>;

inline double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(const Vector& a) { return std::sqrt(dot(a, a)); }
inline Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vector scaled(const Vector& a, double s) { return {s * a[0], s * a[1], s * a[2]}; }
inline Vector sum(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector difference(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// a + s b
inline Vector along(const Vector& a, double s, const Vector& b) {
  return {a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]};
}

// The unit vector at an angle with this cosine to the unit vector `axis`, rotated about it by `turn` (0..1) of a full
// turn.
inline Vector around(const Vector& axis, double cosine, double turn) {
  // Duff et al., Building an Orthonormal Basis, Revisited, JCGT 6(1), 2017
  const double sign = std::copysign(1.0, axis[2]);
  const double a = -1 / (sign + axis[2]), b = axis[0] * axis[1] * a;
  const Vector u{1 + sign * axis[0] * axis[0] * a, sign * b, -sign * axis[0]};
  const Vector v{b, sign + axis[1] * axis[1] * a, -axis[1]};
  const double sine = std::sqrt(std::fmax(0.0, 1 - cosine * cosine)), angle = 2 * std::numbers::pi * turn;
  Vector out{};
  for (std::size_t i = 0; i < 3; ++i) {
    out[i] = cosine * axis[i] + sine * (std::cos(angle) * u[i] + std::sin(angle) * v[i]);
  }
  return out;
}

}  // namespace gicube::emu
