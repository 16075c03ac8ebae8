// Computes the factor of two axis-aligned elements without rays, if only a uniform medium is between them. For elements
// that touch, 1/r^2 has no bound, and the mean of a few rays is too low.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container_hash/hash.hpp>
#include <cstdint>
#include <unordered_map>

#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

// An axis-aligned box, or one of its faces; physical.
struct AxisBox {
  std::array<double, 3> low{}, high{};
  std::uint8_t facing = kMedium;  // of a face, which is flat along its axis: see Leaf::facing
};

// The light between two boxes by path length, for any uniform medium between them.
class WayFactor {
 public:
  // The integrand depends only on the difference of two points, which has a product of trapezoids as distribution. So
  // the integral has three dimensions, not six; its grid is finer towards a difference of zero. Boxes may touch,
  // overlap or be the same.
  WayFactor(const AxisBox& a, const AxisBox& b);
  WayFactor() = default;

  // Mean over both of f f e^(-kappa r) / (pi r^2), where f is the cosine at a face (0 behind it) and 1 in a box. This
  // is PairFactor::transported without sampling; with kappa 0, PairFactor::geometric. The error is at most 5e-5, and in
  // a medium (kappa d / 16)^2 / 24 more, with the longest path d.
  double at(double kappa) const;

  void add(double r, double factor) {
    const auto bin = std::min(static_cast<std::size_t>(r * bins_per_length_), kBins - 1);
    factor_[bin] += factor;
    way_[bin] += factor * r;
  }

 private:
  static constexpr std::size_t kBins = 16;  // chosen: of equal lengths
  double bins_per_length_ = 0;
  std::array<double, kBins> factor_{}, way_{};
};

// Caches factors, because a grid has many pairs with the same offset.
class BoxFactors {
 public:
  explicit BoxFactors(const Edges& edges) : edges_(edges) {}
  // WayFactor::at() of two full clusters; their boxes are multiples of half a voxel.
  double of(const Cluster& a, const Cluster& b, double kappa);

 private:
  using Key = std::array<std::int16_t, 10>;
  struct Known {
    WayFactor way;
    double kappa = -1, factor = 0;  // last request: a fog has one kappa
  };

  Edges edges_;
  std::unordered_map<Key, Known, boost::hash<Key>> known_;
};

}  // namespace gicube::samples
