// Trilinear resampling of density and gradient: seven linear interpolators a channel [P §3.4].
//
// What enters: the eight decoded voxels round a sample and the sample's fractions; what leaves: one word a channel.
// Interpolator words have 16 bits (flow.h), weights are 0.15.
#pragma once

#include <array>
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

// A position's fraction (14 bits) as a weight.
constexpr int weight(std::uint32_t fraction) {
  return static_cast<int>(fraction) << (kWeightBits - wire::kPositionFractionBits);
}

// The eight voxels round a sample: `cell` points at the one of least coordinates, rows and slices of its block are `row`
// and `slice` voxels apart; the weights are the sample's place between them.
struct Neighbourhood {
  const DecodedVoxel* cell;
  std::size_t row;
  std::size_t slice;
  std::array<int, 3> weight;
};

// One channel: 0 density, 1..3 gradient. Channels are apart because a sample of no opacity needs no gradient.
constexpr std::int16_t resample(const Neighbourhood& at, std::size_t channel) {
  const auto along_x = [&at, channel](std::size_t voxel) {
    return lerp(at.cell[voxel].channel[channel], at.cell[voxel + 1].channel[channel], at.weight[0]);
  };
  const std::int16_t near = lerp(along_x(0), along_x(at.row), at.weight[1]);
  const std::int16_t far = lerp(along_x(at.slice), along_x(at.slice + at.row), at.weight[1]);
  return lerp(near, far, at.weight[2]);
}

constexpr Point resample_gradient(const Neighbourhood& at) {
  return {resample(at, 1), resample(at, 2), resample(at, 3)};
}

}  // namespace gicube::emu
