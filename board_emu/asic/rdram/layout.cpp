#include "asic/rdram/layout.h"

#include <algorithm>
#include <array>
#include <optional>
#include <stdexcept>
#include <string>

namespace gicube::emu::rdram {
namespace {

using Stride = std::array<std::uint32_t, 3>;  // pages from a brick to the next along each axis

// Orders of the axes in which bricks are numbered. The first order that separates touching bricks is used. chosen: x z
// y had the best use of DQ at n = 32 (docs/studies/memory_standards.md).
constexpr std::array<std::array<std::size_t, 3>, 6> kAxisOrders{
    {{0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}, {0, 1, 2}}};

std::uint32_t dualocts_of_row(std::uint32_t device_mbit) {
  if (device_mbit == 288) return 128;
  if (device_mbit == 144) return 64;
  throw std::invalid_argument("RDRAM device: expected 144 or 288 Mbit, got " + std::to_string(device_mbit));
}

// Whether two touching bricks would share a bank anywhere in the block.
bool touching_bricks_share_a_bank(const Bricks& bricks, const Stride& stride) {
  const auto reach = [&](std::size_t axis) { return bricks.count[axis] > 1 ? 1 : 0; };
  for (int x = -reach(0); x <= reach(0); ++x) {
    for (int y = -reach(1); y <= reach(1); ++y) {
      for (int z = -reach(2); z <= reach(2); ++z) {
        const int pages =
            x * static_cast<int>(stride[0]) + y * static_cast<int>(stride[1]) + z * static_cast<int>(stride[2]);
        if ((x != 0 || y != 0 || z != 0) && pages % static_cast<int>(Layout::kOpenBanks) == 0) return true;
      }
    }
  }
  return false;
}

std::uint32_t page_of(const std::array<std::uint32_t, 3>& brick, const Stride& stride) {
  return brick[0] * stride[0] + brick[1] * stride[1] + brick[2] * stride[2];
}

// Whether two of four consecutive tiles lie in different pages of one bank, including the ends of rows and slices of
// tiles.
bool consecutive_tiles_share_a_bank(const Bricks& bricks, const Stride& stride) {
  std::array<std::uint32_t, 4> last{};  // pages
  std::uint32_t tile = 0;
  for (std::uint32_t z = 0; z < bricks.tiles[2]; ++z) {
    for (std::uint32_t y = 0; y < bricks.tiles[1]; ++y) {
      const std::uint32_t of_row = y / bricks.size[1] * stride[1] + z / bricks.size[2] * stride[2];
      for (std::uint32_t brick = 0, x = 0; x < bricks.tiles[0]; ++brick) {
        const std::uint32_t page = of_row + brick * stride[0];
        const std::uint32_t end = std::min(x + bricks.size[0], bricks.tiles[0]);
        // All further tiles of this row of a brick have the same page, so the last four do not change with the fourth.
        for (const std::uint32_t checked = std::min(end, x + 4); x < checked; ++x) {
          last[tile++ % 4] = page;
          for (const std::uint32_t other : last) {
            if (other != page && other % Layout::kOpenBanks == page % Layout::kOpenBanks) return true;
          }
        }
        tile += end - x;
        x = end;
      }
    }
  }
  return false;
}

// Numbers the bricks so that touching bricks, and those of consecutive tiles, are in different banks; nothing if no
// order does.
std::optional<Stride> number_bricks(const Bricks& bricks) {
  for (const auto& order : kAxisOrders) {
    Stride stride{};
    std::uint32_t next = 1;
    for (const std::size_t axis : order) {
      stride[axis] = next;
      next *= bricks.count[axis];
    }
    if (!touching_bricks_share_a_bank(bricks, stride) && !consecutive_tiles_share_a_bank(bricks, stride)) {
      return stride;
    }
  }
  return std::nullopt;
}

// Blocks alternate between the two parities of banks; each parity has half of a device.
std::uint32_t devices_needed(std::uint32_t blocks, std::uint32_t pages_of_block) {
  const std::uint64_t pages = (std::uint64_t{blocks} + 1) / 2 * pages_of_block;
  constexpr std::uint64_t kPagesOfParity = std::uint64_t{Layout::kRows} * Layout::kOpenBanks;
  return static_cast<std::uint32_t>(std::max<std::uint64_t>(1, (pages + kPagesOfParity - 1) / kPagesOfParity));
}

}  // namespace

Bricks cut_block(std::uint32_t block_voxels, std::uint32_t device_mbit, std::uint32_t packets) {
  return dram::cut_block("RDRAM", block_voxels, dualocts_of_row(device_mbit) / packets,
                         [](const Bricks& bricks) { return number_bricks(bricks).has_value(); });
}

Layout::Layout(std::uint32_t blocks, std::uint32_t block_voxels, std::uint32_t device_mbit, std::uint32_t packets)
    : dram::LayoutBase(cut_block(block_voxels, device_mbit, packets), packets) {
  devices_ = devices_needed(blocks, bricks_.pages);
  reciprocal_ = ((std::uint64_t{1} << kReciprocalBits) + devices_ - 1) / devices_;
  const Stride stride = *number_bricks(bricks_);
  for (std::uint32_t tile = 0; tile < bricks_.all_tiles(); ++tile) {
    const auto [brick, column] = bricks_.column_of(tile);
    columns_.push_back({static_cast<std::uint16_t>(page_of(brick, stride)), first_column(column)});
  }
}

}  // namespace gicube::emu::rdram
