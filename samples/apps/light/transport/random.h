// Random numbers of a path. They depend only on the seed, the path's number and how many the path has drawn. SplitMix64
// [Steele 2014].
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

#include "gicube/vector.h"

namespace gicube::samples {

class PathRandom {
 public:
  PathRandom(std::uint64_t seed, std::uint64_t path) : state_(mix(mix(seed + kStep) ^ (path + 1) * kStep)) {}

  double uniform() { return static_cast<double>(mix(state_ += kStep) >> 11) * 0x1p-53; }  // [0, 1)
  Vec3 direction() { return direction(1); }                                               // uniform over the sphere
  // Uniform over the directions whose z is at least `1 - 2 * share`: this share of the sphere.
  Vec3 direction(double share) {
    const double z = 1 - 2 * share * uniform(), turn = 2 * std::numbers::pi * uniform();
    const double ring = std::sqrt(std::fmax(0, 1 - z * z));
    return {ring * std::cos(turn), ring * std::sin(turn), z};
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

// `v` in a frame whose z axis is `axis`.
inline Vec3 turned(Vec3 v, Vec3 axis) {
  const Vec3 across = normalise(cross(axis, std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  return v.x * across + v.y * cross(axis, across) + v.z * axis;
}

}  // namespace gicube::samples
