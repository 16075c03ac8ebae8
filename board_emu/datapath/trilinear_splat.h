// Splitting a signed amount among the eight voxels round a place: the trilinear interpolator's tree run backwards.
//
// Each of its seven nodes gives the upper half round(amount x fraction) and the lower half the rest, so the shares sum to
// the amount exactly, and each is within 2 units of the amount's trilinear part. Voxel i of the cell is
// (i & 1, i >> 1 & 1, i >> 2).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/ray.h"

namespace gicube::emu {

using SignedShares = std::array<std::int32_t, 8>;

// round(amount x fraction / 2^14), halves up.
constexpr std::int32_t upper_part(std::int32_t amount, std::uint32_t fraction) {
  constexpr int kBits = wire::kPositionFractionBits;
  return static_cast<std::int32_t>((std::int64_t{amount} * fraction + (1 << (kBits - 1))) >> kBits);
}

// `fraction`: 14 bits an axis. |amount| < 2^24.
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
