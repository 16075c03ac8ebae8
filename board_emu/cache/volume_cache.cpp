#include "cache/volume_cache.h"

#include <algorithm>

namespace gicube::emu {

VolumeCache::VolumeCache(const CacheShape& shape)
    : shape_(shape),
      plain_(shape.ways == 1 && !shape.linear),
      tiles_x_(static_cast<std::size_t>(shape.block_voxels) / 2 + 1),
      slices_(static_cast<std::size_t>(shape.block_voxels) + 1),
      // A way is a share of the same (n+1)^3 words: more ways, fewer sets.
      sets_((tiles_of_block() + shape.ways - 1) / shape.ways),
      tags_(sets_ * shape.ways, kNothing) {}

void VolumeCache::invalidate() { std::fill(tags_.begin(), tags_.end(), kNothing); }

// True if the tile is there; afterwards it is, as the latest used of its set.
inline bool VolumeCache::hit(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z, std::size_t tile) {
  std::size_t set = tile;
  std::uint32_t tag = block;
  if (!plain_) {
    tag = block * static_cast<std::uint32_t>(tiles_of_block()) + static_cast<std::uint32_t>(tile);
    if (shape_.linear) {
      const auto across = static_cast<std::size_t>(shape_.blocks[0]), down = static_cast<std::size_t>(shape_.blocks[1]);
      const auto half = static_cast<std::size_t>(shape_.block_voxels) / 2, n = 2 * half;
      const std::size_t gx = block % across * half + x, gy = block / across % down * half + y,
                        gz = block / (across * down) * n + z;
      set = (gz * down * half + gy) * across * half + gx;
    }
    set %= sets_;
  }
  std::uint32_t* way = tags_.data() + set * shape_.ways;
  if (*way == tag) return true;
  std::uint32_t* const end = way + shape_.ways;
  std::uint32_t* const found = std::find(way, end, tag);
  const bool present = found != end;
  std::copy_backward(way, present ? found : end - 1, present ? found + 1 : end);
  *way = tag;
  return present;
}

// The tiles of the neighbourhood one by one.
const Misses& VolumeCache::look_up(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) {
  const std::size_t x = voxel[0] >> 1, y = voxel[1] >> 1;
  const std::size_t two_x = voxel[0] & 1, two_y = voxel[1] & 1;  // the neighbourhood reaches into the next tile
  const std::size_t last = tiles_x_ - 1;  // the last tile of a row holds one voxel of the block, and padding
  std::uint32_t count = 0;
  for (std::size_t z = voxel[2]; z <= voxel[2] + 1; ++z) {
    for (std::size_t j = y; j <= y + two_y; ++j) {
      const std::size_t row = (z * tiles_x_ + j) * tiles_x_;
      for (std::size_t i = x; i <= x + two_x; ++i) {
        if (plain_) {
          if (tags_[row + i] == block) continue;
          tags_[row + i] = block;
        } else if (hit(block, i, j, z, row + i)) {
          continue;
        }
        misses_.tiles[count++] = static_cast<std::uint32_t>(row + i);
        counters_.filled_voxels += (i != last ? 2u : 1u) << (j != last ? 1 : 0);
      }
    }
  }
  const std::uint32_t missed = count * (two_x != 0 ? 1u : 2u) * (two_y != 0 ? 1u : 2u);
  misses_.count = count;
  counters_.packets += count;
  counters_.missed_voxels += missed;
  ++counters_.misses[missed];
  return misses_;
}

}  // namespace gicube::emu
