// Cuts a volume into the board's blocks: their statistics, whether they must be sent, their packed words, and whether
// rays may skip them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "gicube/vector.h"
#include "gicube/wire/lut.h"

namespace gicube {

// Statistics of all voxels that samples in the block can touch: its own n^3 and those on its +1 faces, inside the
// volume.
struct BlockStatistics {
  std::uint16_t min_density = 0;
  std::uint16_t max_density = 0;
  std::uint8_t tags = 0;  // bit t: a voxel has tag t

  friend constexpr bool operator==(const BlockStatistics&, const BlockStatistics&) = default;
};

// Blocks are numbered b = bx + nx (by + ny bz), as in memory_map.h.
class VoxelBlocks {
 public:
  // One density (0..4095), gradient code and tag, and three bytes of colour per voxel, x fastest. Without tags all are
  // 0; without codes no voxel has a gradient.
  struct Voxels {
    std::span<const std::uint16_t> densities, codes;
    std::span<const std::uint8_t> tags, colours;
  };
  // Keeps only the spans: their memory must live until the last pack(). `n`: the board's block edge, voxels. Throws
  // BadArgument if it is odd, because a block would not begin on a whole byte.
  VoxelBlocks(Dims dims, int n, const Voxels& voxels);

  Dims blocks() const { return blocks_; }
  std::size_t count() const { return statistics_.size(); }

  // False if all voxels of the block and its +1 faces have density 0, no gradient, tag 0 and colour black, as the
  // board's cleared memory.
  bool stored(std::size_t block) const { return stored_[block]; }

  // The block's n^3 words of 36 bits, x fastest, packed as in voxel.h, followed by their colours if there are any.
  // Voxels outside of the volume are zero. Resizes `out`.
  void pack(std::size_t block, std::vector<std::uint8_t>& out) const;

  const BlockStatistics& statistics(std::size_t block) const { return statistics_[block]; }
  std::span<const BlockStatistics> statistics() const { return statistics_; }

 private:
  // The voxels [begin, end) of a block, with `overlap` more at its upper faces, clipped to the volume.
  struct Region {
    std::array<std::size_t, 3> begin, end;
  };
  Region region(std::size_t block, int overlap) const;
  BlockStatistics find_statistics(const Region& region) const;
  // `values`: `of_voxel` for each voxel, or none.
  bool has_nonzero(const auto& values, std::size_t of_voxel, const Region& region) const;
  std::size_t row(std::size_t y, std::size_t z) const;  // index of voxel (0, y, z)
  std::uint64_t word(std::size_t voxel) const {
    const std::uint8_t tag = voxels_.tags.empty() ? std::uint8_t{0} : voxels_.tags[voxel];
    const std::uint16_t code = voxels_.codes.empty() ? std::uint16_t{wire::kNoGradient} : voxels_.codes[voxel];
    return wire::to_word(wire::Voxel{voxels_.densities[voxel], code, tag, 0});
  }

  Dims dims_;
  int n_;
  Dims blocks_;
  Voxels voxels_;
  std::vector<BlockStatistics> statistics_;
  std::vector<bool> stored_;
};

// Whether samples with this entry have any opacity.
constexpr bool is_visible(const wire::SegmentationEntry& entry) { return entry.opacity > 0 || entry.opacity_fine > 0; }

// One flag per block; 1: no sample in it can be visible, because for each of its tags all entries between its least and
// its greatest density have opacity 0. `lut`: all 2^14 entries, index = tag << 12 | density. Throws BadArgument if the
// LUT has another size.
std::vector<std::uint8_t> find_empty_blocks(std::span<const BlockStatistics> blocks,
                                            std::span<const wire::SegmentationEntry> lut);

// Packs flags as in memory_map.h's region empty_flags: block b in bit b % 8 of byte b / 8, 1 for nonzero flags.
std::vector<std::uint8_t> pack_flags(std::span<const std::uint8_t> flags);

}  // namespace gicube
