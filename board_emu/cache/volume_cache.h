// The tags of a processor's volume cache: which tiles of which block it holds, or has asked for [P §2.1, §3.3].
//
// The cache has a place for each of a block's (n+1)^3 voxels. Memory brings 2x2x1 tiles (docs/HARDWARE.md), so the tags of
// a tile's four voxels are always the same and are kept once. Lazy: nothing is fetched before a sample needs it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace gicube::emu {

struct CacheShape {
  int block_voxels = 32;
  unsigned ways = 1;
  // The baseline of [P §5.1]: places are taken by a tile's linear address in the whole volume, not in its block.
  bool linear = false;
  std::array<int, 3> blocks{};  // of the volume
};

struct CacheCounters {
  std::uint64_t checks = 0;               // trilinear neighbourhoods looked up
  std::uint64_t packets = 0;              // tiles asked for
  std::uint64_t missed_voxels = 0;        // of the eight a check needs
  std::uint64_t filled_voxels = 0;        // that the packets bring, padding left out
  std::array<std::uint64_t, 9> misses{};  // checks by their missed voxels, 0..8
};

struct Misses {
  std::uint32_t count = 0;  // packets
  std::array<std::uint32_t, 8> tiles;
};

class VolumeCache {
 public:
  explicit VolumeCache(const CacheShape& shape);

  // Looks up the neighbourhood of the cell at `voxel` of `block`. Missing tiles count as present from now on.
  const Misses& check(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) {
    ++counters_.checks;
    misses_.count = 0;
    if (present(block, voxel)) {
      ++counters_.misses[0];
      return misses_;
    }
    return look_up(block, voxel);
  }

  // Drops every tile: memory has changed.
  void invalidate();

  std::size_t tiles_of_block() const { return tiles_x_ * tiles_x_ * slices_; }
  const CacheCounters& counters() const { return counters_; }

 private:
  static constexpr std::uint32_t kNothing = ~std::uint32_t{0};

  // Whether a direct mapped cache holds the whole neighbourhood: the usual case, without a branch a tile.
  bool present(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) const {
    if (!plain_) return false;
    const std::size_t to_x = voxel[0] & 1, to_y = (voxel[1] & 1) * tiles_x_;
    const std::uint32_t* near = tags_.data() + (voxel[2] * tiles_x_ + (voxel[1] >> 1)) * tiles_x_ + (voxel[0] >> 1);
    const std::uint32_t* far = near + tiles_x_ * tiles_x_;
    return ((near[0] ^ block) | (near[to_x] ^ block) | (near[to_y] ^ block) | (near[to_y + to_x] ^ block) |
            (far[0] ^ block) | (far[to_x] ^ block) | (far[to_y] ^ block) | (far[to_y + to_x] ^ block)) == 0;
  }
  const Misses& look_up(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel);
  bool hit(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z, std::size_t tile);

  CacheShape shape_;
  bool plain_;           // direct mapped, by the place in the block
  std::size_t tiles_x_;  // of a block along x, and along y
  std::size_t slices_;   // along z
  std::size_t sets_;
  std::vector<std::uint32_t> tags_;  // sets_ x ways, the latest used first
  Misses misses_;
  CacheCounters counters_;
};

}  // namespace gicube::emu
