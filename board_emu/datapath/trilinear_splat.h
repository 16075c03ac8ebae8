// Splits a deposit among the eight voxels around a position [P §2.2: trilinear splat]. Voxel i of the cell is
// (i & 1, i >> 1 & 1, i >> 2) [H923].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

// Splits whole energy units by systematic rounding: on average each voxel gets the fraction of its trilinear weight,
// and the shares of one deposit sum to it exactly. `fraction`: 14 bits per axis. `units` < 2^32; `chance` decides the
// roundings.
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

// Splits a signed amount by the trilinear interpolator's tree run backwards: each of its seven nodes gives
// round(amount x fraction) to the upper half and the rest to the lower half, so the shares sum to the amount exactly,
// and each is within 2 units of the amount's trilinear part.
using SignedShares = std::array<std::int32_t, 8>;

// round(amount x fraction / 2^14), halves up.
constexpr std::int32_t upper_part(std::int32_t amount, std::uint32_t fraction) {
  constexpr int kBits = wire::kPositionFractionBits;
  return static_cast<std::int32_t>((std::int64_t{amount} * fraction + (1 << (kBits - 1))) >> kBits);
}

// `fraction`: 14 bits per axis. |amount| < 2^24.
constexpr SignedShares spread(std::int32_t amount, const std::array<std::uint32_t, 3>& fraction) {
  SignedShares shares{};
  shares[0] = amount;
  for (std::size_t axis = 3; axis-- > 0;) {
    const std::size_t upper = std::size_t{1} << axis, stride = 2 * upper;
    for (std::size_t i = 0; i < 8; i += stride) {
      shares[i + upper] = upper_part(shares[i], fraction[axis]);
      shares[i] -= shares[i + upper];
    }
  }
  return shares;
}

}  // namespace gicube::emu
