// The range of densities and the set of tags in cells of 4^3 voxels, including their far faces. If no density of the
// range is visible, samples add nothing and need not be taken.
//
// A host structure of the functional level; the board has no such memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "functional/simd/block_ranges.h"
#include "memory/large_array.h"
#include "memory/volume_memory.h"

namespace gicube::emu {

class CellRanges {
 public:
  static constexpr int kEdgeShift = kCellEdgeShift;

  // Updates the ranges if `volume` was decoded since the last call.
  void follow(const VolumeMemory& volume, unsigned threads);
  void clear() { *this = {}; }

  // Cells of the whole volume, x fastest. Blocks that are not decoded have the cells of the zero block.
  std::span<const CellRange> cells() const { return cells_; }
  const std::array<int, 3>& size() const { return size_; }

 private:
  void follow_block(const VolumeMemory& volume, std::size_t block);

  std::uint64_t decoded_ = 0;
  std::array<int, 3> size_{};
  LargeArray<CellRange> cells_;
};

}  // namespace gicube::emu
