// The tags of a processor's volume cache: the tiles that are present or requested, and their blocks [P §2.1, §3.3].
//
// The cache has room for each of a block's (n+1)^3 voxels. Memory delivers 2x2x1 tiles [H309-H314], so
// the four voxels of a tile always have the same tag, which is kept once unless the configuration asks for tags of
// single voxels. Fetching is lazy: a tile is requested when a sample needs it.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "gicube/archive.h"

namespace gicube::emu {

struct CacheShape {
  int block_voxels = 32;
  unsigned ways = 1;
  // The baseline of [P §5.1]: a tile's set comes from its linear address in the whole volume, not in its block.
  bool linear = false;
  std::array<int, 3> blocks{};  // of the volume
  bool writes_back = false;     // the cache records which tiles have changed
  unsigned tile_depth = 1;      // voxels of a tile along z; 2 x 2 across
  bool tags_of_voxels = false;  // direct mapped; only the requested voxels of a packet are kept
};

// A tile of a block.
struct TileOfBlock {
  std::uint32_t block = 0;
  std::uint32_t tile = 0;

  friend bool operator==(const TileOfBlock&, const TileOfBlock&) = default;
};

struct CacheCounters {
  std::uint64_t checks = 0;               // trilinear neighbourhoods looked up
  std::uint64_t packets = 0;              // tiles asked for
  std::uint64_t missed_voxels = 0;        // of the eight voxels that a check needs
  std::uint64_t filled_voxels = 0;        // voxels in the packets, without padding
  std::array<std::uint64_t, 9> misses{};  // checks by their missed voxels, 0..8

  void state(Archive::Record& record) { record(checks, packets, missed_voxels, filled_voxels, misses); }
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
    if (shape_.writes_back) [[unlikely]]
      note_evictions(block, voxel);
    return plain_ ? check_plain(block, voxel) : check_sets(block, voxel);
  }

  // Like check(), but calls fetch(tile) for each missing tile. Only for a cache that is_plain() and does not write
  // back.
  template <typename Fetch>
  void for_each_miss(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel, const Fetch& fetch);

  // Whether it is direct mapped by the position in the block and has one tag per tile.
  bool is_plain() const { return plain_; }

  // Whether a tile is present or requested.
  bool probe(std::uint32_t block, std::uint32_t tile) const {
    return plain_ ? tags_[tile] == block : probe_in_set(block, tile);
  }

  // Returns whether a tile is present, and makes it present. Not for a direct mapped cache of tiles that are one voxel
  // deep.
  bool access(std::uint32_t block, std::uint32_t tile);

  // Write-back caches only. Marks a present tile as changed; false if it was marked already.
  bool change(std::uint32_t block, std::uint32_t tile);
  // Changed tiles that the latest check() or access() has evicted.
  const std::vector<TileOfBlock>& evictions() const { return evictions_; }
  bool has_changes() const { return changes_ > 0; }
  // Returns some changed tile and unmarks it. There must be one.
  TileOfBlock clean();

  // Drops every tile, after memory has changed.
  void invalidate();

  std::size_t tiles_of_block() const { return slice_tiles_ * slices_; }
  const CacheCounters& counters() const { return counters_; }

  std::size_t sets() const { return sets_; }
  unsigned ways() const { return shape_.ways; }
  bool has_tags_of_voxels() const { return shape_.tags_of_voxels; }
  // The tile in a way of a set, present or requested; the most recently used way first. Not for a cache with tags of
  // voxels.
  struct Way {
    TileOfBlock tile;
    bool is_changed = false;
  };
  std::optional<Way> way(std::size_t set, std::size_t way) const;
  // Between runs no tile is marked as changed.
  void state(Archive& archive) {
    archive.expect_idle(changes_ == 0, "a cache that writes back");
    archive("tags", tags_);
    if (!changed_.empty()) archive.at_most("cleaned", cleaned_, changed_.size() - 1);
    archive("counters", counters_);
    if (archive.in_run() && !changed_.empty()) changes_state(archive);
  }

 private:
  static constexpr std::uint32_t kNothing = ~std::uint32_t{0};

  const Misses& check_plain(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel);
  const Misses& check_sets(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel);
  const Misses& check_voxels(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel);
  bool probe_voxels(std::uint32_t block, std::uint32_t tile) const;
  bool probe_in_set(std::uint32_t block, std::uint32_t tile) const;
  void count(std::uint32_t packets, std::uint32_t voxels_of_tile) {
    misses_.count = packets;
    ++counters_.checks;
    counters_.packets += packets;
    counters_.missed_voxels += packets * voxels_of_tile;
    ++counters_.misses[packets * voxels_of_tile];
  }
  // The tag that a voxel has when it is present, and its index in tags_.
  struct VoxelTag {
    std::size_t index = 0;
    std::uint32_t value = 0;
  };
  VoxelTag tag_of_voxel(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z) const;
  // Index in tags_ of the set's first way.
  std::size_t set_of(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z, std::size_t tile) const;
  bool hit(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z, std::size_t tile);

  void changes_state(Archive& archive);
  void note_evictions(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel);
  // Index in tags_ of a present tile.
  std::size_t index_of(std::uint32_t block, std::uint32_t tile) const;
  TileOfBlock tile_at(std::size_t index) const;

  CacheShape shape_;
  bool plain_;           // direct mapped by the position in the block
  std::size_t tiles_x_;  // of a block along x, and along y
  std::size_t slice_tiles_;
  std::size_t slices_;  // along z
  std::size_t sets_;
  std::vector<std::uint32_t> tags_;       // sets_ x ways, the most recently used first
  std::vector<std::uint32_t> first_way_;  // by tile, the index of its set; not with `linear`
  std::vector<std::uint8_t> changed_;     // by index in tags_; write-back caches only
  std::size_t changes_ = 0;               // marked tiles
  std::size_t cleaned_ = 0;               // index in tags_ up to which clean() has searched
  std::vector<TileOfBlock> evictions_;
  Misses misses_;
  CacheCounters counters_;
};

// Usually nothing is missing; four compares of two tags each find that out.
inline const Misses& VolumeCache::check_plain(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) {
  misses_.count = 0;
  for_each_miss(block, voxel, [this](std::uint32_t tile) { misses_.tiles[misses_.count++] = tile; });
  return misses_;
}

template <typename Fetch>
[[gnu::always_inline]] inline void VolumeCache::for_each_miss(std::uint32_t block,
                                                              const std::array<std::uint32_t, 3>& voxel,
                                                              const Fetch& fetch) {
  const std::uint32_t two_x = voxel[0] & 1, two_y = voxel[1] & 1;  // the neighbourhood reaches into the next tile
  const std::size_t x = voxel[0] >> 1, y = voxel[1] >> 1;
  const std::size_t first = (voxel[2] * tiles_x_ + y) * tiles_x_ + x;
  std::uint32_t* const tags = tags_.data() + first;
  const auto differs = [tags, block](std::size_t tile) {
    const auto pair = std::bit_cast<std::uint64_t>(std::array{tags[tile], tags[tile + 1]});
    return pair ^ std::bit_cast<std::uint64_t>(std::array{block, block});
  };
  const std::size_t row = two_y * tiles_x_, slice = slice_tiles_;
  const std::array<std::uint64_t, 4> different{differs(0), differs(row), differs(slice), differs(slice + row)};
  const std::uint64_t of_both = std::bit_cast<std::uint64_t>(std::array{~0u, two_x != 0 ? ~0u : 0u});
  const std::uint32_t voxels_of_tile = 4u >> (two_x + two_y);
  ++counters_.checks;
  if (((different[0] | different[1] | different[2] | different[3]) & of_both) == 0) [[likely]] {
    ++counters_.misses[0];
    return;
  }
  // One bit per tile: x, then y, then z. Duplicates count once.
  const std::uint32_t once = (two_x != 0 ? 0xFFu : 0x55u) & (two_y != 0 ? 0xFFu : 0x33u);
  std::uint32_t missing = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto pair = std::bit_cast<std::array<std::uint32_t, 2>>(different[i]);
    missing |= (pair[0] != 0 ? 1u : 0u) << (2 * i) | (pair[1] != 0 ? 2u : 0u) << (2 * i);
  }
  missing &= once;
  const std::size_t last = tiles_x_ - 1;  // the last tile of a row holds one voxel of the block, and padding
  const bool is_inside = x + 1 < last && y + 1 < last;
  const std::array<std::size_t, 4> rows{0, row, slice, slice + row};
  std::uint32_t packets = 0;
  for (; missing != 0; missing &= missing - 1, ++packets) {
    const auto i = static_cast<std::size_t>(std::countr_zero(missing));
    const std::size_t tile = rows[i >> 1] + (i & 1);
    if (!is_inside)
      counters_.filled_voxels -= 4u - (x + (i & 1) == last ? 1u : 2u) * ((y + (i >> 1 & 1)) == last ? 1u : 2u);
    tags[tile] = block;
    fetch(static_cast<std::uint32_t>(first + tile));
  }
  counters_.filled_voxels += 4u * packets;
  counters_.packets += packets;
  counters_.missed_voxels += packets * voxels_of_tile;
  ++counters_.misses[packets * voxels_of_tile];
}

}  // namespace gicube::emu
