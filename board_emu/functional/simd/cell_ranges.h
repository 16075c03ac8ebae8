// The range of densities and the set of tags in cells of 4^3 voxels, including their far faces. If no density of the
// range is visible, samples add nothing and need not be taken.
//
// A host structure of the functional level; the board has no such memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "memory/large_array.h"
#include "memory/volume_memory.h"

namespace gicube::emu {

inline constexpr int kCellEdgeShift = 2;  // cells of 4^3 voxels

struct CellRange {
  std::uint16_t least = 0, most = 0;  // densities of 12 bits
  std::uint8_t tags = 1;              // one bit per tag

  friend constexpr bool operator==(const CellRange&, const CellRange&) = default;
};

struct BlockCells {
  const std::int16_t* densities = nullptr;  // 12.3, (n+1)^3
  const std::uint16_t* codes = nullptr;     // for their tags (words.h); null: tag 0 everywhere
  std::size_t voxels = 0;                   // n: 8, 16, 32 or 64
};

// Computes the ranges of the cells of one decoded block, with the host's vectors. Writes to `out`, in which
// neighbouring cells along y and z are `across` and `slice` apart.
void find_ranges(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice);
// find_ranges() voxel by voxel.
void find_ranges_one_by_one(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice);

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
