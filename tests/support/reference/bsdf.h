// What the hardware's five ways to scatter do to a direction, in closed form [P §2.2]. A dull one adds to a unit vector
// m a vector of length beta whose direction is even over the sphere; with z the cosine between the two, the sum's angle
// to m has the cosine (1 + beta z) / sqrt(1 + 2 beta z + beta^2).
#pragma once

#include <algorithm>
#include <cmath>

namespace gicube::reference {

// Mean of that cosine over the sphere: the integral of (s^2 + 1 - beta^2) / (4 beta) over the sum's length s.
inline double dull_mean(double beta) { return beta <= 1 ? 1 - beta * beta / 3 : 2 / (3 * beta); }

// Of its absolute value, for a sum that is reflected at the plane through its foot.
inline double folded_dull_mean(double beta) {
  if (beta <= 1) return dull_mean(beta);
  const auto f = [beta](double s) { return s * s * s / 3 + (1 - beta * beta) * s; };
  return (f(1 + beta) - 2 * f(std::sqrt(beta * beta - 1)) + f(beta - 1)) / (4 * beta);
}

// Share of directions whose cosine is at most `cosine` > 0, for beta <= 1: those between the two z that give it.
inline double dull_share(double beta, double cosine) {
  const double c2 = cosine * cosine, root = c2 + beta * beta - 1;
  if (root <= 0) return 0;
  const double middle = -(1 - c2) / beta, half = cosine * std::sqrt(root) / beta;
  return (std::clamp(middle + half, -1.0, 1.0) - std::clamp(middle - half, -1.0, 1.0)) / 2;
}

}  // namespace gicube::reference
