// Trilinear resampling of density and gradient: seven linear interpolators a channel [P §3.4].
//
// What enters: the eight decoded voxels round a sample and the sample's fractions; what leaves: one decoded voxel.
// Interpolator words have 16 bits (flow.h), weights are 0.15.
#pragma once

#include <cstddef>
#include <cstdint>

#include "flow.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

inline constexpr int kWeightBits = 15;

// a + round((b - a) w), w in 0.15.
constexpr std::int16_t lerp(std::int16_t a, std::int16_t b, int w) {
  return static_cast<std::int16_t>(a + (((b - a) * w + (1 << (kWeightBits - 1))) >> kWeightBits));
}

constexpr DecodedVoxel lerp(const DecodedVoxel& a, const DecodedVoxel& b, int w) {
  DecodedVoxel out;
  for (std::size_t c = 0; c < 4; ++c) out.channel[c] = lerp(a.channel[c], b.channel[c], w);
  return out;
}

// A position's fraction (14 bits) as a weight.
constexpr int weight(std::uint32_t fraction) {
  return static_cast<int>(fraction) << (kWeightBits - wire::kPositionFractionBits);
}

// `cell` points at the voxel of least coordinates; rows and slices of its block are `row` and `slice` voxels apart.
constexpr DecodedVoxel resample(const DecodedVoxel* cell, std::size_t row, std::size_t slice, int wx, int wy, int wz) {
  const DecodedVoxel c00 = lerp(cell[0], cell[1], wx);
  const DecodedVoxel c10 = lerp(cell[row], cell[row + 1], wx);
  const DecodedVoxel c01 = lerp(cell[slice], cell[slice + 1], wx);
  const DecodedVoxel c11 = lerp(cell[slice + row], cell[slice + row + 1], wx);
  return lerp(lerp(c00, c10, wy), lerp(c01, c11, wy), wz);
}

}  // namespace gicube::emu
