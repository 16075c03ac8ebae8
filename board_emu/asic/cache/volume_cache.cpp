#include "asic/cache/volume_cache.h"

#include <algorithm>
#include <utility>

namespace gicube::emu {

namespace {

std::size_t voxels_of_block(const CacheShape& shape) {
  const auto edge = static_cast<std::size_t>(shape.block_voxels) + 1;
  return edge * edge * edge;
}

}  // namespace

VolumeCache::VolumeCache(const CacheShape& shape)
    : shape_(shape),
      plain_(shape.ways == 1 && !shape.linear && shape.tile_depth == 1 && !shape.tags_of_voxels),
      tiles_x_(static_cast<std::size_t>(shape.block_voxels) / 2 + 1),
      slice_tiles_(tiles_x_ * tiles_x_),
      slices_(static_cast<std::size_t>(shape.block_voxels) / shape.tile_depth + 1),
      // A way is a share of the same (n+1)^3 words: more ways, fewer sets.
      sets_(((shape.tags_of_voxels ? voxels_of_block(shape) : tiles_of_block()) + shape.ways - 1) / shape.ways),
      tags_(sets_ * shape.ways, kNothing),
      changed_(shape.writes_back ? tags_.size() : 0) {
  if (plain_ || shape.linear || shape.tags_of_voxels) return;
  for (std::size_t tile = 0; tile < tiles_of_block(); ++tile) {
    first_way_.push_back(static_cast<std::uint32_t>(tile % sets_ * shape.ways));
  }
}

void VolumeCache::invalidate() {
  std::ranges::fill(tags_, kNothing);
  std::ranges::fill(changed_, std::uint8_t{0});
  changes_ = 0;
}

// In a direct mapped cache the index in tags_ is the tile's number.
TileOfBlock VolumeCache::tile_at(std::size_t index) const {
  if (plain_) return {tags_[index], static_cast<std::uint32_t>(index)};
  const auto tiles = static_cast<std::uint32_t>(tiles_of_block());
  return {tags_[index] / tiles, tags_[index] % tiles};
}

std::optional<VolumeCache::Way> VolumeCache::way(std::size_t set, std::size_t way) const {
  const std::size_t index = set * shape_.ways + way;
  if (tags_[index] == kNothing) return std::nullopt;
  return Way{tile_at(index), !changed_.empty() && changed_[index] != 0};
}

std::size_t VolumeCache::index_of(std::uint32_t block, std::uint32_t tile) const {
  if (plain_) return tile;
  const auto tag = block * static_cast<std::uint32_t>(tiles_of_block()) + tile;
  const std::size_t first = set_of(block, tile % tiles_x_, tile / tiles_x_ % tiles_x_, tile / slice_tiles_, tile);
  const auto way = tags_.begin() + static_cast<std::ptrdiff_t>(first);
  return static_cast<std::size_t>(std::find(way, way + shape_.ways, tag) - tags_.begin());
}

bool VolumeCache::change(std::uint32_t block, std::uint32_t tile) {
  std::uint8_t& changed = changed_[index_of(block, tile)];
  const bool is_new = changed == 0;
  changed = 1;
  changes_ += is_new ? 1 : 0;
  return is_new;
}

TileOfBlock VolumeCache::clean() {
  while (changed_[cleaned_] == 0) cleaned_ = (cleaned_ + 1) % changed_.size();
  changed_[cleaned_] = 0;
  --changes_;
  return tile_at(cleaned_);
}

void VolumeCache::changes_state(Archive& archive) {
  const auto blocks = static_cast<std::uint64_t>(shape_.blocks[0]) * static_cast<std::uint64_t>(shape_.blocks[1]) *
                      static_cast<std::uint64_t>(shape_.blocks[2]);
  std::vector<std::uint32_t> indices;
  for (std::uint32_t index = 0; index < changed_.size(); ++index) {
    if (changed_[index] != 0) indices.push_back(index);
  }
  archive.list("changed", indices, changed_.size());
  if (!archive.loads()) return;
  for (const std::uint32_t index : indices) {
    const bool is_new = index < changed_.size() && changed_[index] == 0 && tile_at(index).block < blocks;
    archive.expect(is_new, "changed", "indices of present tiles, each once", index);
    changed_[index] = 1;
  }
  changes_ = indices.size();
}

// Called before the check of a direct mapped cache. With several ways, hit() finds the evictions.
void VolumeCache::note_evictions(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) {
  evictions_.clear();
  if (!plain_ || changes_ == 0) return;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t x = (voxel[0] + (i & 1)) >> 1, y = (voxel[1] + (i >> 1 & 1)) >> 1, z = voxel[2] + (i >> 2);
    const std::size_t tile = (z * tiles_x_ + y) * tiles_x_ + x;
    if (tags_[tile] == block || changed_[tile] == 0) continue;
    evictions_.push_back(tile_at(tile));
    changed_[tile] = 0;
    --changes_;
  }
}

std::size_t VolumeCache::set_of(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z,
                                std::size_t tile) const {
  if (!shape_.linear) return first_way_[tile];
  const auto across = static_cast<std::size_t>(shape_.blocks[0]), down = static_cast<std::size_t>(shape_.blocks[1]);
  const auto half = static_cast<std::size_t>(shape_.block_voxels) / 2, n = 2 * half;
  const std::size_t gx = block % across * half + x, gy = block / across % down * half + y,
                    gz = block / (across * down) * n + z;
  return ((gz * down * half + gy) * across * half + gx) % sets_ * shape_.ways;
}

VolumeCache::VoxelTag VolumeCache::tag_of_voxel(std::uint32_t block, std::size_t x, std::size_t y,
                                                std::size_t z) const {
  const auto n = static_cast<std::size_t>(shape_.block_voxels);
  if (!shape_.linear) return {(z * (n + 1) + y) * (n + 1) + x, block};
  const auto across = static_cast<std::size_t>(shape_.blocks[0]), down = static_cast<std::size_t>(shape_.blocks[1]);
  const std::size_t gx = block % across * n + x, gy = block / across % down * n + y,
                    gz = block / (across * down) * n + z;
  const std::size_t address = (gz * down * n + gy) * across * n + gx;
  return {address % sets_, static_cast<std::uint32_t>(address)};
}

// A packet is requested once, however many of its voxels are missing.
const Misses& VolumeCache::check_voxels(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) {
  std::uint32_t packets = 0, missing = 0;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::size_t x = voxel[0] + (i & 1), y = voxel[1] + (i >> 1 & 1), z = voxel[2] + (i >> 2);
    const VoxelTag tag = tag_of_voxel(block, x, y, z);
    if (std::exchange(tags_[tag.index], tag.value) == tag.value) continue;
    ++missing;
    const auto tile = static_cast<std::uint32_t>((z / shape_.tile_depth * tiles_x_ + (y >> 1)) * tiles_x_ + (x >> 1));
    const auto asked = misses_.tiles.begin() + packets;
    if (std::find(misses_.tiles.begin(), asked, tile) == asked) misses_.tiles[packets++] = tile;
  }
  misses_.count = packets;
  ++counters_.checks;
  ++counters_.misses[missing];
  counters_.packets += packets;
  counters_.missed_voxels += missing;
  counters_.filled_voxels += missing;
  return misses_;
}

bool VolumeCache::probe_voxels(std::uint32_t block, std::uint32_t tile) const {
  const auto n = static_cast<std::size_t>(shape_.block_voxels), depth = std::size_t{shape_.tile_depth};
  const std::size_t x = tile % tiles_x_ * 2, y = tile / tiles_x_ % tiles_x_ * 2, z = tile / slice_tiles_ * depth;
  for (std::size_t i = 0; i < 4 * depth; ++i) {  // the last tile of a row holds fewer voxels of the block, and padding
    const VoxelTag tag =
        tag_of_voxel(block, std::min(x + (i & 1), n), std::min(y + (i >> 1 & 1), n), std::min(z + (i >> 2), n));
    if (tags_[tag.index] != tag.value) return false;
  }
  return true;
}

bool VolumeCache::probe_in_set(std::uint32_t block, std::uint32_t tile) const {
  if (shape_.tags_of_voxels) return probe_voxels(block, tile);
  const auto tag = block * static_cast<std::uint32_t>(tiles_of_block()) + tile;
  const std::uint32_t* const way =
      tags_.data() + set_of(block, tile % tiles_x_, tile / tiles_x_ % tiles_x_, tile / slice_tiles_, tile);
  return std::find(way, way + shape_.ways, tag) != way + shape_.ways;
}

bool VolumeCache::access(std::uint32_t block, std::uint32_t tile) {
  evictions_.clear();
  return hit(block, tile % tiles_x_, tile / tiles_x_ % tiles_x_, tile / slice_tiles_, tile);
}

// True if the tile is present. Afterwards it is present and the most recently used of its set.
bool VolumeCache::hit(std::uint32_t block, std::size_t x, std::size_t y, std::size_t z, std::size_t tile) {
  const auto tag = block * static_cast<std::uint32_t>(tiles_of_block()) + static_cast<std::uint32_t>(tile);
  std::uint32_t* const way = tags_.data() + set_of(block, x, y, z, tile);
  if (*way == tag) return true;
  std::uint32_t* const end = way + shape_.ways;
  std::uint32_t* const found = std::find(way, end, tag);
  const bool present = found != end;
  std::uint32_t* const last = present ? found : end - 1;  // the tag that is overwritten
  if (!changed_.empty()) {
    std::uint8_t* const changed = changed_.data() + (way - tags_.data());
    const auto index = last - way;
    const std::uint8_t moves = present ? changed[index] : 0;
    if (!present && changed[index] != 0) {
      evictions_.push_back(tile_at(static_cast<std::size_t>(last - tags_.data())));
      --changes_;
    }
    std::copy_backward(changed, changed + index, changed + index + 1);
    *changed = moves;
  }
  std::copy_backward(way, last, last + 1);
  *way = tag;
  return present;
}

const Misses& VolumeCache::check_sets(std::uint32_t block, const std::array<std::uint32_t, 3>& voxel) {
  if (shape_.tags_of_voxels) return check_voxels(block, voxel);
  const std::size_t x = voxel[0] >> 1, y = voxel[1] >> 1;
  const std::size_t two_x = voxel[0] & 1, two_y = voxel[1] & 1;
  const std::size_t last = tiles_x_ - 1;
  std::uint32_t missing = 0;
  const std::size_t depth = shape_.tile_depth, last_z = (voxel[2] + 1) / depth;
  for (std::size_t z = voxel[2] / depth; z <= last_z; ++z) {
    for (std::size_t j = y; j <= y + two_y; ++j) {
      for (std::size_t i = x; i <= x + two_x; ++i) {
        const std::size_t tile = (z * tiles_x_ + j) * tiles_x_ + i;
        if (hit(block, i, j, z, tile)) continue;
        misses_.tiles[missing++] = static_cast<std::uint32_t>(tile);
        counters_.filled_voxels += (i != last ? 2u : 1u) * (j != last ? 2u : 1u);
      }
    }
  }
  const std::size_t two_z = last_z - voxel[2] / depth;  // slices of tiles, less one
  count(missing, 8u >> (two_x + two_y + two_z));
  return misses_;
}

}  // namespace gicube::emu
