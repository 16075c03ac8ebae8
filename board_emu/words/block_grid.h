// Maps positions to the volume's blocks, and to positions within a block.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "gicube/wire/ray.h"
#include "words/words.h"

namespace gicube::emu {

// Finds a position's block, and the corners of blocks.
class BlockGrid {
 public:
  BlockGrid() = default;
  // `blocks`: number of blocks along x, y, z.
  BlockGrid(int block_voxels, const std::array<int, 3>& blocks)
      : shift_(std::countr_zero(static_cast<unsigned>(block_voxels)) + wire::kPositionFractionBits),
        across_(static_cast<std::size_t>(blocks[0])),
        slice_(across_ * static_cast<std::size_t>(blocks[1])) {}
  // The grid of anything that is stored in blocks.
  template <typename Volume>
  explicit BlockGrid(const Volume& volume) : BlockGrid(volume.block_voxels(), volume.blocks()) {}

  std::size_t block(const Point& position) const {
    return static_cast<std::size_t>(position[0] >> shift_) + across_ * static_cast<std::size_t>(position[1] >> shift_) +
           slice_ * static_cast<std::size_t>(position[2] >> shift_);
  }
  // Whether two positions are in the same block.
  bool same(const Point& a, const Point& b) const {
    return (((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) >> shift_) == 0;
  }
  Point low(const Point& position) const {
    const std::int32_t mask = -(std::int32_t{1} << shift_);
    return {position[0] & mask, position[1] & mask, position[2] & mask};
  }
  std::int32_t size() const { return std::int32_t{1} << shift_; }  // edge of a block, in position units
  // The voxel of a block with the least coordinates.
  std::array<std::int32_t, 3> corner(std::size_t block) const {
    const int voxels = shift_ - wire::kPositionFractionBits;
    return {static_cast<std::int32_t>(block % across_) << voxels,
            static_cast<std::int32_t>(block % slice_ / across_) << voxels,
            static_cast<std::int32_t>(block / slice_) << voxels};
  }

 private:
  int shift_ = 0;
  std::size_t across_ = 0;
  std::size_t slice_ = 0;
};

// A sample's position in its block: whole voxels and fractions.
struct Cell {
  std::array<std::uint32_t, 3> voxel;
  std::array<std::uint32_t, 3> fraction;
};

inline Cell cell(const Point& position, const Point& low) {
  constexpr std::uint32_t kFractionMask = static_cast<std::uint32_t>(wire::kVoxel) - 1;
  Cell out;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto offset = static_cast<std::uint32_t>(position[axis] - low[axis]);
    out.voxel[axis] = offset >> wire::kPositionFractionBits;
    out.fraction[axis] = offset & kFractionMask;
  }
  return out;
}

}  // namespace gicube::emu
