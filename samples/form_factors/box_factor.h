// The factor of two elements along the axes without a ray, if nothing but an even medium is between them. Where elements
// touch, 1/r^2 has no bound, and the mean of few rays is too low.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>

#include "form_factors/radiosity.h"

namespace gicube::samples {

// A box along the axes, or one of its faces; physical.
struct AxisBox {
  std::array<double, 3> low{}, high{};
  std::uint8_t facing = kMedium;  // of a face: flat along its axis, as Leaf::facing
};

// Mean over both of f f e^(-kappa r) / (pi r^2), f the cosine at a face (0 behind it) and 1 in a box: PairFactor::transported
// without sampling, and with kappa 0 PairFactor::geometric, within 5e-5 of it. Boxes may touch, overlap or be one and the same.
//
// The integrand hangs on the difference of two points alone, whose distribution is a product of trapezoids: so it is an
// integral over three dimensions, not six, and is graded towards a difference of zero.
double mean_factor(const AxisBox& a, const AxisBox& b, double kappa = 0);

// Keeps what it worked out: in a grid the same offsets come again and again.
class BoxFactors {
 public:
  explicit BoxFactors(Vec3 edges) : edges_(edges) {}
  // Of two full clusters; their boxes are multiples of half a voxel.
  double of(const Cluster& a, const Cluster& b) { return at_grade(a, b, kClear); }
  // The same with an even medium between them; interpolated between kappas that are kept.
  double of(const Cluster& a, const Cluster& b, double kappa);

 private:
  using Key = std::array<std::int16_t, 11>;
  static constexpr std::int16_t kClear = -32768;
  double at_grade(const Cluster& a, const Cluster& b, std::int16_t grade);
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };

  Vec3 edges_;
  std::unordered_map<Key, double, Hash> known_;
};

}  // namespace gicube::samples
