// Computes the ranges of the cells of one decoded block (cell_ranges.h), with the host's vectors.
#pragma once

#include <cstddef>
#include <cstdint>

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

// Writes to `out`, in which neighbouring cells along y and z are `across` and `slice` apart.
void find_ranges(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice);
// find_ranges() voxel by voxel.
void find_ranges_one_by_one(const BlockCells& block, CellRange* out, std::size_t across, std::size_t slice);

}  // namespace gicube::emu
