// The tiles of a block that a deposit writes.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "words/words.h"

namespace gicube::emu {

struct SplatTiles {
  std::uint32_t count = 0;
  std::array<std::uint32_t, 8> tile{};
};

// A block as deposits see it.
struct SplatBlock {
  std::array<std::int32_t, 3> corner{};  // voxels
  std::int32_t edge = 0;                 // voxels, its +1 face included
  std::int32_t last = 0;                 // the last voxel that is written, along each axis
  std::int32_t tile_depth = 1;           // voxels of a tile along z
};

// Those of voxels with a share, or of `all` voxels.
inline SplatTiles tiles_of(const Deposit& deposit, const SplatBlock& block, bool all) {
  SplatTiles out;
  const std::int32_t tiles_x = block.edge / 2 + 1;
  for (std::size_t i = 0; i < 8; ++i) {
    if (deposit.shares[i] == 0 && !all) continue;
    std::array<std::int32_t, 3> local{};
    bool held = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      local[axis] = deposit.voxel[axis] + static_cast<std::int32_t>(i >> axis & 1) - block.corner[axis];
      held = held && local[axis] >= 0 && local[axis] <= block.last;
    }
    if (!held) continue;
    const auto tile =
        static_cast<std::uint32_t>((local[2] / block.tile_depth * tiles_x + local[1] / 2) * tiles_x + local[0] / 2);
    const auto end = out.tile.begin() + out.count;
    if (std::find(out.tile.begin(), end, tile) == end) out.tile[out.count++] = tile;
  }
  return out;
}

}  // namespace gicube::emu
