// Smooth noise without a period: values of 0..1 at hashed lattice points, joined by cubic weights.
#pragma once

#include <cmath>
#include <cstdint>

#include "gicube/vector.h"

namespace gicube::samples::results {

inline double lattice_value(int x, int y, int z) {
  std::uint64_t hash = static_cast<std::uint32_t>(x) * 0x9E3779B97F4A7C15u;
  hash ^= static_cast<std::uint32_t>(y) * 0xC2B2AE3D27D4EB4Fu;
  hash ^= static_cast<std::uint32_t>(z) * 0x165667B19E3779F9u;
  hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9u;  // SplitMix64's finalizer
  hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EBu;
  return static_cast<double>((hash ^ (hash >> 31)) >> 40) / double(1 << 24);
}

inline double noise(Vec3 p) {
  const double fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const auto mix = [](double a, double b, double t) { return a + (b - a) * t; };
  const double u = smooth(p.x - fx), v = smooth(p.y - fy), w = smooth(p.z - fz);
  const auto row = [&](int dy, int dz) {
    return mix(lattice_value(x, y + dy, z + dz), lattice_value(x + 1, y + dy, z + dz), u);
  };
  return mix(mix(row(0, 0), row(1, 0), v), mix(row(0, 1), row(1, 1), v), w);
}

// Three octaves, 0..1.
inline double cloudy_noise(Vec3 p) {
  return (4 * noise(p) + 2 * noise(2.0 * p + Vec3{17, 5, 29}) + noise(4.0 * p + Vec3{3, 41, 11})) / 7;
}

}  // namespace gicube::samples::results
