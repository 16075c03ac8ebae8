#include "asic/cache/volume_cache.h"

#include <algorithm>

namespace gicube::emu {

VolumeCache::VolumeCache(const CacheShape& shape)
    : shape_(shape),
      plain_(shape.ways == 1 && !shape.linear),
      tiles_x_(static_cast<std::size_t>(shape.block_voxels) / 2 + 1),
      slice_tiles_(tiles_x_ * tiles_x_),
      slices_(static_cast<std::size_t>(shape.block_voxels) + 1),
      // A way is a share of the same (n+1)^3 words: more ways, fewer sets.
      sets_((tiles_of_block() + shape.ways - 1) / shape.ways),
      tags_(sets_ * shape.ways, kNothing) {
  if (plain_ || shape.linear) return;
  for (std::size_t tile = 0; tile < tiles_of_block(); ++tile) {
    first_way_.push_back(static_cast<std::uint32_t>(tile % sets_ * shape.ways));
  }
}

void VolumeCache::invalidate() { std::fill(tags_.begin(), tags_.end(), kNothing); }

std::size_t VolumeCache::set_of(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z,
                                std::size_t tile) const {
  if (!shape_.linear) return first_way_[tile];
  const auto across = static_cast<std::size_t>(shape_.blocks[0]), down = static_cast<std::size_t>(shape_.blocks[1]);
  const auto half = static_cast<std::size_t>(shape_.block_voxels) / 2, n = 2 * half;
  const std::size_t gx = block % across * half + x, gy = block / across % down * half + y,
                    gz = block / (across * down) * n + z;
  return ((gz * down * half + gy) * across * half + gx) % sets_ * shape_.ways;
}

bool VolumeCache::holds(std::uint32_t block, std::uint32_t tile) const {
  if (plain_) return tags_[tile] == block;
  const auto tag = block * static_cast<std::uint32_t>(tiles_of_block()) + tile;
  const std::uint32_t* const way =
      tags_.data() + set_of(block, tile % tiles_x_, tile / tiles_x_ % tiles_x_, tile / slice_tiles_, tile);
  return std::find(way, way + shape_.ways, tag) != way + shape_.ways;
}

// True if the tile is there; afterwards it is, as the latest used of its set.
bool VolumeCache::hit(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z, std::size_t tile) {
  const auto tag = block * static_cast<std::uint32_t>(tiles_of_block()) + static_cast<std::uint32_t>(tile);
  std::uint32_t* const way = tags_.data() + set_of(block, x, y, z, tile);
  if (*way == tag) return true;
  std::uint32_t* const end = way + shape_.ways;
  std::uint32_t* const found = std::find(way, end, tag);
  const bool present = found != end;
  std::copy_backward(way, present ? found : end - 1, present ? found + 1 : end);
  *way = tag;
  return present;
}

const Misses& VolumeCache::check_sets(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) {
  const std::size_t x = voxel[0] >> 1, y = voxel[1] >> 1;
  const std::size_t two_x = voxel[0] & 1, two_y = voxel[1] & 1;
  const std::size_t last = tiles_x_ - 1;
  std::uint32_t missing = 0;
  for (std::size_t z = voxel[2]; z <= voxel[2] + 1; ++z) {
    for (std::size_t j = y; j <= y + two_y; ++j) {
      for (std::size_t i = x; i <= x + two_x; ++i) {
        const std::size_t tile = (z * tiles_x_ + j) * tiles_x_ + i;
        if (hit(block, i, j, z, tile)) continue;
        misses_.tiles[missing++] = static_cast<std::uint32_t>(tile);
        counters_.filled_voxels += (i != last ? 2u : 1u) * (j != last ? 2u : 1u);
      }
    }
  }
  count(missing, 4u >> (two_x + two_y));
  return misses_;
}

}  // namespace gicube::emu
