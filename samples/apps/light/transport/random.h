// Random numbers of a path: they depend on the seed, the path's number and how many it has drawn. SplitMix64 [Steele
// 2014].
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "gicube/vector.h"

namespace gicube::samples {

class PathRandom {
 public:
  PathRandom(std::uint64_t seed, std::uint64_t path) : state_(mix(mix(seed + kStep) ^ (path + 1) * kStep)) {}

  double uniform() { return static_cast<double>(mix(state_ += kStep) >> 11) * 0x1p-53; }  // [0, 1)
  Vec3 direction() { return direction(1); }                                               // even over the sphere
  // Even over the directions whose z is at least `1 - 2 * share`: this share of the sphere.
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

// Points that fill a square evenly, however many (Roberts 2018); `shift`: another set of them.
inline std::array<double, 2> spread_point(int i, const std::array<double, 2>& shift) {
  constexpr double kU = 0.7548776662466927, kV = 0.5698402909980532;
  const double u = shift[0] + kU * i, v = shift[1] + kV * i;
  return {u - std::floor(u), v - std::floor(v)};
}

// `v`, given for an axis along z, turned to `axis`.
inline Vec3 turned(Vec3 v, Vec3 axis) {
  const Vec3 across = normalise(cross(axis, std::abs(axis.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
  return v.x * across + v.y * cross(axis, across) + v.z * axis;
}

}  // namespace gicube::samples
