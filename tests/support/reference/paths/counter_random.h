// Random numbers that depend on a seed, a stream's number and how many were drawn, and on nothing else: paths that have
// streams of their own are the same on any number of threads. SplitMix64 (Steele, Lea, Flood 2014) from a mixed key.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "gicube/vector.h"

namespace gicube::reference::paths {

class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, std::uint64_t stream) : state_(mix(mix(seed + kStep) ^ (stream + 1) * kStep)) {}

  double uniform() { return static_cast<double>(mix(state_ += kStep) >> 11) * 0x1p-53; }  // [0, 1)
  double exponential() { return -std::log1p(-uniform()); }                                // of mean 1
  Vec3 direction() {                                                                      // even over the sphere
    const double z = 1 - 2 * uniform(), phi = 2 * std::numbers::pi * uniform();
    const double ring = std::sqrt(1 - z * z);
    return {ring * std::cos(phi), ring * std::sin(phi), z};
  }

 private:
  static constexpr std::uint64_t kStep = 0x9E3779B97F4A7C15;
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9;
    z = (z ^ z >> 27) * 0x94D049BB133111EB;
    return z ^ z >> 31;
  }

  std::uint64_t state_;
};

}  // namespace gicube::reference::paths
