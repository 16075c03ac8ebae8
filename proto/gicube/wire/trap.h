// A ray whose material only the host application can scatter: its form on the bus, and the conversion of its words for
// a scattering routine. Board and driver share these functions, so that routines on both sides receive the same
// numbers.
//
// To the host, 64 bytes: a TrappedRay. To the board, 32 bytes: the same packet, except for
//   direction                    direction in which it continues
//   contribution, interaction    together 24 bits, contribution the high ones: the share of its energy, or of what it
//                                can still gather, that ends here; 2^24 - 1 = all
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "gicube/wire/ray.h"
#include "gicube/wire/registers.h"

namespace gicube::wire {

inline constexpr int kTrapDensityFractionBits = 3;
inline constexpr double kTrapOpacityOne = 65535;

struct TrappedRay {
  Ray ray;                                 // at the material; kTrapped if it is a surface, which the ray then passes
  std::array<std::int16_t, 3> gradient{};  // 511 * 2^5 = 1; points to higher density
  std::uint16_t density = 0;               // unsigned 12.3
  std::uint16_t opacity = 0;               // opacity of one voxel length there, 65535 = 1
  std::uint8_t tag = 0;
  std::array<std::uint32_t, 4> random{};  // 2^32 = 1: random numbers drawn for this event

  constexpr void fields(auto&& list) { list(ray, gradient, density, opacity, tag, Reserved<5>{}, random); }
  friend constexpr bool operator==(const TrappedRay&, const TrappedRay&) = default;
};
inline constexpr std::size_t kTrappedRayBytes = bytes_of<TrappedRay>();

// The share that ends at the trap, from a packet sent to the board; 0..kOpacityOne.
constexpr std::uint32_t dropped_share(const Ray& ray) {
  return std::uint32_t{ray.contribution} << 12 | (ray.interaction & 0xFFFu);
}
constexpr void set_dropped_share(Ray& ray, std::uint32_t share) {
  ray.contribution = static_cast<std::uint16_t>(share >> 12);
  ray.interaction = static_cast<std::uint16_t>(share & 0xFFFu);
}
// The share that ends, from the share 0..1 that continues.
inline std::uint32_t dropped_share(double passes) {
  return static_cast<std::uint32_t>(std::lround((1 - passes) * kOpacityOne));
}

// Valid lengths of a direction returned by a routine. chosen: squares and voxel spacings keep their precision.
inline constexpr double kShortestDirection = 1e-6, kLongestDirection = 1e6;

using Triple = std::array<double, 3>;
using Spacing = std::array<std::uint32_t, 3>;  // the SPACING registers

// A vector too short to have a direction is returned unchanged.
inline Triple unit(const Triple& a) {
  const double length = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
  if (!(length > 1e-9)) return a;
  const double scale = 1 / length;
  return {a[0] * scale, a[1] * scale, a[2] * scale};
}

// Converts a ray's direction to a physical unit vector, and back.
inline Triple physical_direction(const std::array<std::int16_t, 3>& direction, const Spacing& spacing) {
  Triple out{};
  for (std::size_t axis = 0; axis < 3; ++axis) out[axis] = static_cast<double>(direction[axis]) * spacing[axis];
  return unit(out);
}
inline std::array<std::int16_t, 3> direction_words(const Triple& physical, const Spacing& spacing) {
  Triple voxels{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    voxels[axis] = physical[axis] * (double{kSpacingOne} / spacing[axis]);
  }
  voxels = unit(voxels);
  std::array<std::int16_t, 3> out{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    out[axis] = static_cast<std::int16_t>(std::lround(voxels[axis] * (1 << kDirectionFractionBits)));
  }
  return out;
}

// Unit vector against the gradient; zero if there is none.
inline Triple surface_normal(const std::array<std::int16_t, 3>& gradient) {
  const auto against = [&gradient](std::size_t axis) { return -static_cast<double>(gradient[axis]); };
  if (gradient == std::array<std::int16_t, 3>{}) return {};
  return unit({against(0), against(1), against(2)});
}

}  // namespace gicube::wire
