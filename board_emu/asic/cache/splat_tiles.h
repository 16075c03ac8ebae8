// The tiles of a block that a deposit writes [H960].
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "words/words.h"

namespace gicube::emu {

struct SplatTiles {
  std::uint32_t count = 0;
  std::array<std::uint32_t, 8> tile{};
};

// The extent of a block for deposits.
struct SplatBlock {
  std::array<std::int32_t, 3> corner{};  // voxels
  std::int32_t edge = 0;                 // voxels, its +1 face included
  std::int32_t last = 0;                 // the last voxel that is written, along each axis
  std::int32_t tile_depth = 1;           // voxels of a tile along z
};

// Tiles of the voxels that get a share, or of all eight voxels if `all`, in the order of their first voxels.
inline SplatTiles tiles_of(const Deposit& deposit, const SplatBlock& block, bool all) {
  // Masks of the four lower voxels along each axis, one bit per voxel.
  constexpr std::array<std::uint32_t, 3> kLower{0x55, 0x33, 0x0F};
  std::uint32_t voxels = 0;
  for (std::uint32_t i = 0; i < 8; ++i) voxels |= (deposit.shares[i] != 0 || all ? 1u : 0u) << i;
  std::array<std::int32_t, 3> local{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    local[axis] = deposit.voxel[axis] - block.corner[axis];
    const auto held = [&](std::int32_t at) { return at >= 0 && at <= block.last ? 0xFFu : 0u; };
    voxels &= (held(local[axis]) & kLower[axis]) | (held(local[axis] + 1) & ~kLower[axis]);
  }
  const std::int32_t tiles_x = block.edge / 2 + 1, flat = block.tile_depth == 1 ? 1 : 0;
  const std::int32_t first = ((local[2] >> (1 - flat)) * tiles_x + (local[1] >> 1)) * tiles_x + (local[0] >> 1);
  // Mask of the axes along which the upper voxels lie in other tiles than the lower ones.
  const std::uint32_t parted =
      static_cast<std::uint32_t>((local[0] & 1) | (local[1] & 1) << 1 | ((local[2] & 1) | flat) << 2);
  SplatTiles out;
  for (std::uint32_t seen = 0; voxels != 0; voxels &= voxels - 1) {
    const std::uint32_t tile = static_cast<std::uint32_t>(std::countr_zero(voxels)) & parted;
    if ((seen >> tile & 1) != 0) continue;
    seen |= 1u << tile;
    const auto is = [tile](int axis) { return static_cast<std::int32_t>(tile >> axis & 1); };
    out.tile[out.count++] = static_cast<std::uint32_t>(first + (is(2) * tiles_x + is(1)) * tiles_x + is(0));
  }
  return out;
}

}  // namespace gicube::emu
