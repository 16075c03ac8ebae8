#include "asic/rdram/layout.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gicube::emu::rdram {
namespace {

// Axes in the order in which bricks are numbered; the first order that keeps touching bricks apart is taken. Chosen: of
// the orders, x z y had the best use of DQ at n = 32 (docs/reference/hardware.md).
constexpr std::array<std::array<std::size_t, 3>, 6> kAxisOrders{
    {{0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}, {0, 1, 2}}};

std::uint32_t dualocts_of_row(std::uint32_t device_mbit) {
  if (device_mbit == 288) return 128;
  if (device_mbit == 144) return 64;
  throw std::invalid_argument("RDRAM device: expected 144 or 288 Mbit, got " + std::to_string(device_mbit));
}

std::array<std::uint32_t, 3> brick_counts(const Bricks& bricks) {
  std::array<std::uint32_t, 3> counts{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    counts[axis] = (bricks.tiles[axis] + bricks.size[axis] - 1) / bricks.size[axis];
  }
  return counts;
}

// Whether two bricks that touch would share a bank, in some place of the block.
bool touching_bricks_share_a_bank(const Bricks& bricks) {
  const auto counts = brick_counts(bricks);
  const auto reach = [&counts](std::size_t axis) { return counts[axis] > 1 ? 1 : 0; };
  for (int x = -reach(0); x <= reach(0); ++x) {
    for (int y = -reach(1); y <= reach(1); ++y) {
      for (int z = -reach(2); z <= reach(2); ++z) {
        const int pages = x * static_cast<int>(bricks.stride[0]) + y * static_cast<int>(bricks.stride[1]) +
                          z * static_cast<int>(bricks.stride[2]);
        if ((x != 0 || y != 0 || z != 0) && pages % static_cast<int>(Layout::kOpenBanks) == 0) return true;
      }
    }
  }
  return false;
}

std::uint32_t page_of(const Bricks& bricks, std::uint32_t tile) {
  const auto& [tiles, size, stride, pages] = bricks;
  const std::uint32_t x = tile % tiles[0], y = tile / tiles[0] % tiles[1], z = tile / (tiles[0] * tiles[1]);
  return x / size[0] * stride[0] + y / size[1] * stride[1] + z / size[2] * stride[2];
}

// Whether two of four consecutive tiles lie in different pages of one bank: also where a row or a slice of tiles ends.
bool consecutive_tiles_share_a_bank(const Bricks& bricks) {
  const std::uint32_t tiles = bricks.tiles[0] * bricks.tiles[1] * bricks.tiles[2];
  std::array<std::uint32_t, 4> last{};  // pages
  last.fill(page_of(bricks, 0));
  for (std::uint32_t tile = 0; tile < tiles; ++tile) {
    const std::uint32_t page = page_of(bricks, tile);
    last[tile % 4] = page;
    for (const std::uint32_t other : last) {
      if (other != page && other % Layout::kOpenBanks == page % Layout::kOpenBanks) return true;
    }
  }
  return false;
}

// Numbers the bricks so that touching ones and consecutive tiles' are in different banks; false if no order does.
bool number_bricks(Bricks& bricks) {
  const auto counts = brick_counts(bricks);
  for (const auto& order : kAxisOrders) {
    std::uint32_t stride = 1;
    for (const std::size_t axis : order) {
      bricks.stride[axis] = stride;
      stride *= counts[axis];
    }
    if (!touching_bricks_share_a_bank(bricks) && !consecutive_tiles_share_a_bank(bricks)) return true;
  }
  return false;
}

// Pages of a block times the surface of a brick in voxel faces (a tile is 2 x 2 x 1 voxels): memory that a block takes, and
// pages that rays which march together have open at once.
std::uint32_t cost(const Bricks& bricks) {
  const std::uint32_t x = 2 * bricks.size[0], y = 2 * bricks.size[1], z = bricks.size[2];
  return bricks.pages * (x * y + y * z + z * x);
}

}  // namespace

Bricks cut_block(std::uint32_t block_voxels, std::uint32_t device_mbit) {
  if (block_voxels < 2 || block_voxels > 64 || block_voxels % 2 != 0) {
    throw std::invalid_argument("block of the RDRAM layout: expected an even 2 to 64 voxels, got " +
                                std::to_string(block_voxels));
  }
  const std::uint32_t row = dualocts_of_row(device_mbit), flat = block_voxels / 2 + 1, deep = block_voxels + 1;
  Bricks best;
  for (std::uint32_t x = 1; x <= std::min(flat, row); ++x) {
    for (std::uint32_t y = 1; y <= std::min(flat, row / x); ++y) {
      for (std::uint32_t z = 1; z <= std::min(deep, row / (x * y)); ++z) {
        Bricks bricks{{flat, flat, deep}, {x, y, z}, {}, 0};
        const auto counts = brick_counts(bricks);
        bricks.pages = counts[0] * counts[1] * counts[2];
        if ((best.pages == 0 || cost(bricks) < cost(best)) && number_bricks(bricks)) best = bricks;
      }
    }
  }
  return best;
}

std::uint32_t devices_needed(std::uint32_t blocks, std::uint32_t block_voxels, std::uint32_t device_mbit) {
  // Blocks go to the two parities in turn, and each parity has half of a device.
  const std::uint64_t pages = (std::uint64_t{blocks} + 1) / 2 * cut_block(block_voxels, device_mbit).pages;
  constexpr std::uint64_t kPagesOfParity = std::uint64_t{Layout::kRows} * Layout::kOpenBanks;
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(1, (pages + kPagesOfParity - 1) / kPagesOfParity));
}

Layout::Layout(std::uint32_t blocks, std::uint32_t block_voxels, std::uint32_t device_mbit)
    : bricks_(cut_block(block_voxels, device_mbit)),
      devices_(devices_needed(blocks, block_voxels, device_mbit)),
      reciprocal_(((std::uint64_t{1} << kReciprocalBits) + devices_ - 1) / devices_) {
  const auto& [tiles, size, stride, pages] = bricks_;
  const std::uint32_t count = tiles[0] * tiles[1] * tiles[2];
  places_.reserve(count);
  for (std::uint32_t tile = 0; tile < count; ++tile) {
    const std::uint32_t x = tile % tiles[0], y = tile / tiles[0] % tiles[1], z = tile / (tiles[0] * tiles[1]);
    const std::uint32_t column = x % size[0] + size[0] * (y % size[1] + size[1] * (z % size[2]));
    places_.push_back({static_cast<std::uint16_t>(page_of(bricks_, tile)), static_cast<std::uint8_t>(column)});
  }
}

}  // namespace gicube::emu::rdram
