// Splitting a deposit of whole energy units among the eight voxels round a place [P §2.2: trilinear splat].
//
// Systematic rounding: each voxel's share is its trilinear weight's part on average, and the shares of one deposit sum to
// it exactly. Voxel i of the cell is (i & 1, i >> 1 & 1, i >> 2).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

// `fraction`: 14 bits an axis. `units` < 2^32; `chance` decides the roundings.
constexpr Shares split(std::uint32_t units, const std::array<std::uint32_t, 3>& fraction, std::uint64_t chance) {
  constexpr int kBits = wire::kPositionFractionBits;
  constexpr std::uint32_t kOne = 1u << kBits;
  constexpr int kSumBits = 28;  // two axes exactly, the third rounded down by the running sum's differences
  const std::uint64_t offset = chance >> (64 - kSumBits);
  Shares shares{};
  std::uint64_t weight_sum = 0, given = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    std::uint64_t weight = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      weight *= (i >> axis & 1) != 0 ? fraction[axis] : kOne - fraction[axis];
    }
    weight_sum += weight;  // 42 bits, 2^42 after the last
    const std::uint64_t until = (units * (weight_sum >> (3 * kBits - kSumBits)) + offset) >> kSumBits;
    shares[i] = static_cast<std::uint32_t>(until - given);
    given = until;
  }
  return shares;
}

}  // namespace gicube::emu
