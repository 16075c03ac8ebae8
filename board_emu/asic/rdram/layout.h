// The placement of the blocks' tiles in one channel's RDRAMs.
//
// A page is one row of one bank: 128 dualocts (288 Mbit) or 64 (144 Mbit), a brick of 3 x 6 x 7 tiles at n = 32. All
// pages of a block lie in banks of one parity, 16 of them per row number, so its pages conflict only within a bank.
// Bricks that touch, even at a corner, are never in the same bank. The packets of a trilinear neighbourhood, and of any
// four consecutive tiles, that need an activation therefore go to different banks, none next to another: RDRAM's
// four-access rule. Measurements are in docs/studies/memory_standards.md [H1406, H1407].
#pragma once

#include <cstdint>

#include "asic/dram/layout.h"
#include "asic/dram/memory.h"

namespace gicube::emu::rdram {

using dram::Bricks, dram::Location;

// The cheapest bricks that satisfy the four-access rule.
Bricks cut_block(std::uint32_t block_voxels, std::uint32_t device_mbit, std::uint32_t packets = 1);

class Layout : public dram::LayoutBase {
 public:
  // `blocks`: those of this channel. n = `block_voxels`: even, 8..64. `device_mbit`: 144 or 288. `packets`: those of a
  // tile.
  Layout(std::uint32_t blocks, std::uint32_t block_voxels, std::uint32_t device_mbit, std::uint32_t packets = 1);

  // Tile `tile` (x fastest) of the channel's block `block`, each counted from 0.
  Location locate(std::uint32_t block, std::uint32_t tile) const {
    const PageColumn at_page = columns_[tile];
    // Even blocks take even banks, odd blocks odd ones. Groups of 16 pages alternate between the devices.
    const std::uint32_t page = (block >> 1) * bricks_.pages + at_page.page;
    const std::uint32_t group = page / kOpenBanks;
    const auto row = static_cast<std::uint32_t>(group * reciprocal_ >> kReciprocalBits);  // group / devices_
    Location at;
    at.device = static_cast<std::uint16_t>(group - row * devices_);
    at.row = static_cast<std::uint16_t>(row);
    at.bank = static_cast<std::uint8_t>(2 * (page % kOpenBanks) + (block & 1));
    at.column = at_page.column;
    return at;
  }

  static constexpr std::uint32_t kRows = 512;      // rows of a bank
  static constexpr std::uint32_t kOpenBanks = 16;  // banks that can be open together: every other of 32

 private:
  // Exact for up to 2^20 groups and 2^10 devices, which covers every volume of the board.
  static constexpr unsigned kReciprocalBits = 40;

  std::uint64_t reciprocal_;
};

}  // namespace gicube::emu::rdram
