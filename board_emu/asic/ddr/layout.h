// Where the tiles of the blocks lie in one channel of DDR SDRAM.
//
// A page is one row of one bank of a rank: 1024 columns of 72 bits, that is 512 packets. It holds a brick of neighbouring
// tiles, so that rays that march together hit open rows in whatever direction they go. There are only 4 banks: bricks that
// share a face are never in the same bank (bank = x + 2 y + 3 z mod 4 of the brick's place, and on from block to block);
// of those that touch at an edge or a corner some are.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "asic/dram/access.h"

namespace gicube::emu::ddr {

using dram::Location;

// How a block of n^3 voxels with its +1 faces is cut into pages.
struct Bricks {
  std::array<std::uint32_t, 3> tiles{};  // of the block, per axis: n/2 + 1, n/2 + 1, n + 1
  std::array<std::uint32_t, 3> size{};   // of a brick, in tiles
  std::array<std::uint32_t, 3> count{};  // bricks, per axis
};

// The bricks with the least product of pages and surface.
Bricks cut_block(std::uint32_t block_voxels);

class Layout {
 public:
  // `blocks` of n = `block_voxels` in this channel (n even, 8..64).
  Layout(std::uint32_t blocks, std::uint32_t block_voxels);

  std::uint32_t devices() const { return ranks_; }
  std::uint32_t tiles() const { return static_cast<std::uint32_t>(places_.size()); }  // of a block
  const Bricks& bricks() const { return bricks_; }

  // Tile `tile` (x fastest) of the channel's block `block`, each counted from 0.
  Location locate(std::uint32_t block, std::uint32_t tile) const {
    const Place place = places_[tile];
    const std::uint32_t page = block * pages_ + place.page;
    const std::uint32_t row = page / kBanksOfRank;  // of all ranks, in turn
    Location at;
    at.device = static_cast<std::uint16_t>(row % ranks_);
    at.row = static_cast<std::uint16_t>(row / ranks_);
    at.bank = static_cast<std::uint8_t>(page % kBanksOfRank);
    at.column = place.column;
    return at;
  }

  static constexpr std::uint32_t kBanksOfRank = 4;
  static constexpr std::uint32_t kRows = 4096;         // of a bank
  static constexpr std::uint32_t kPacketsOfRow = 512;  // 1024 columns, two a packet

 private:
  struct Place {
    std::uint16_t page;
    std::uint16_t column;
  };

  Bricks bricks_;
  std::uint32_t pages_ = 0;  // that a block takes, with those that stay empty
  std::uint32_t ranks_ = 1;
  std::vector<Place> places_;
};

}  // namespace gicube::emu::ddr
