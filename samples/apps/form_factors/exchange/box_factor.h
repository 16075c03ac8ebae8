// The factor of two elements along the axes without a ray, if nothing but an even medium is between them. Where
// elements touch, 1/r^2 has no bound, and the mean of few rays is too low.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container_hash/hash.hpp>
#include <cstdint>
#include <unordered_map>

#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

// A box along the axes, or one of its faces; physical.
struct AxisBox {
  std::array<double, 3> low{}, high{};
  std::uint8_t facing = kMedium;  // of a face: flat along its axis, as Leaf::facing
};

// The light between two boxes by the length of its way: of any even medium between them at once.
class WayFactor {
 public:
  // The integrand depends on the difference of two points alone, whose distribution is a product of trapezoids: so it
  // is an integral over three dimensions, not six, and is graded towards a difference of zero. Boxes may touch, overlap
  // or be one and the same.
  WayFactor(const AxisBox& a, const AxisBox& b);
  WayFactor() = default;

  // Mean over both of f f e^(-kappa r) / (pi r^2), f the cosine at a face (0 behind it) and 1 in a box:
  // PairFactor::transported without sampling, and with kappa 0 PairFactor::geometric. Within 5e-5 of it, and in a
  // medium within (kappa d / 16)^2 / 24 besides, d the longest way.
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

// Keeps what it worked out: in a grid the same offsets come again and again.
class BoxFactors {
 public:
  explicit BoxFactors(const Edges& edges) : edges_(edges) {}
  // WayFactor::at() of two full clusters; their boxes are multiples of half a voxel.
  double of(const Cluster& a, const Cluster& b, double kappa);

 private:
  using Key = std::array<std::int16_t, 10>;
  struct Known {
    WayFactor way;
    double kappa = -1, factor = 0;  // the last that was asked for: a fog has one kappa
  };

  Edges edges_;
  std::unordered_map<Key, Known, boost::hash<Key>> known_;
};

}  // namespace gicube::samples
