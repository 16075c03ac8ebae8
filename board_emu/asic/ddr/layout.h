// The placement of the blocks' tiles in one channel of DDR SDRAM.
//
// A page is one row of one bank of a rank: 1024 columns of 72 bits, that is 512 packets. With only 4 banks, bricks that
// share a face are never in the same bank, but some that touch at an edge or a corner are. The bank is x + 2 y + 3 z
// mod 4 of the brick's position, and blocks follow one another [H1504].
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "asic/dram/layout.h"
#include "asic/dram/memory.h"

namespace gicube::emu::ddr {

using dram::Bricks, dram::Location;

inline constexpr std::uint32_t kPacketsOfRow = 512;  // 1024 columns, two per packet

inline Bricks cut_block(std::uint32_t block_voxels, std::uint32_t packets = 1) {
  return dram::cut_block("DDR", block_voxels, kPacketsOfRow / packets, [](const Bricks&) { return true; });
}

class Layout : public dram::LayoutBase {
 public:
  // `blocks`: those of this channel. n = `block_voxels`: even, 8..64. `packets`: those of a tile.
  Layout(std::uint32_t blocks, std::uint32_t block_voxels, std::uint32_t packets = 1)
      : dram::LayoutBase(cut_block(block_voxels, packets), packets) {
    const auto& count = bricks_.count;
    // Each brick takes the first free page of its bank.
    std::array<std::uint32_t, kBanksOfRank> next{0, 1, 2, 3};
    std::vector<std::uint32_t> page_of(bricks_.pages);
    for (std::uint32_t brick = 0; brick < page_of.size(); ++brick) {
      const std::uint32_t x = brick % count[0], y = brick / count[0] % count[1], z = brick / (count[0] * count[1]);
      std::uint32_t& page = next[(x + 2 * y + 3 * z) % kBanksOfRank];
      page_of[brick] = page;
      pages_ = std::max(pages_, page + 1);
      page += kBanksOfRank;
    }
    const std::uint64_t rows = (std::uint64_t{blocks} * pages_ + kBanksOfRank - 1) / kBanksOfRank;
    devices_ = static_cast<std::uint32_t>(std::max<std::uint64_t>(1, (rows + kRows - 1) / kRows));
    for (std::uint32_t tile = 0; tile < bricks_.all_tiles(); ++tile) {
      const auto [brick, column] = bricks_.column_of(tile);
      const std::uint32_t page = page_of[brick[0] + count[0] * (brick[1] + count[1] * brick[2])];
      columns_.push_back({static_cast<std::uint16_t>(page), first_column(column)});
    }
  }

  // Tile `tile` (x fastest) of the channel's block `block`, each counted from 0.
  Location locate(std::uint32_t block, std::uint32_t tile) const {
    const PageColumn at_page = columns_[tile];
    const std::uint32_t page = block * pages_ + at_page.page;
    const std::uint32_t row = page / kBanksOfRank;  // counted over all ranks in turn
    Location at;
    at.device = static_cast<std::uint16_t>(row % devices_);
    at.row = static_cast<std::uint16_t>(row / devices_);
    at.bank = static_cast<std::uint8_t>(page % kBanksOfRank);
    at.column = at_page.column;
    return at;
  }

  static constexpr std::uint32_t kBanksOfRank = 4;
  static constexpr std::uint32_t kRows = 4096;  // rows of a bank

 private:
  std::uint32_t pages_ = 0;  // pages of a block, including those that stay empty
};

}  // namespace gicube::emu::ddr
