#include "asic/ddr/layout.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gicube::emu::ddr {
namespace {

// Pages of a block times the surface of a brick in voxel faces (a tile is 2 x 2 x 1 voxels): memory that a block takes, and
// pages that rays which march together have open at once.
std::uint32_t cost(const Bricks& bricks) {
  const std::uint32_t x = 2 * bricks.size[0], y = 2 * bricks.size[1], z = bricks.size[2];
  return bricks.count[0] * bricks.count[1] * bricks.count[2] * (x * y + y * z + z * x);
}

}  // namespace

Bricks cut_block(std::uint32_t block_voxels) {
  if (block_voxels < 2 || block_voxels > 64 || block_voxels % 2 != 0) {
    throw std::invalid_argument("block of the DDR layout: expected an even 2 to 64 voxels, got " +
                                std::to_string(block_voxels));
  }
  constexpr std::uint32_t kRow = Layout::kPacketsOfRow;
  const std::uint32_t flat = block_voxels / 2 + 1, deep = block_voxels + 1;
  Bricks best;
  for (std::uint32_t x = 1; x <= flat; ++x) {
    for (std::uint32_t y = 1; y <= std::min(flat, kRow / x); ++y) {
      for (std::uint32_t z = 1; z <= std::min(deep, kRow / (x * y)); ++z) {
        Bricks bricks{{flat, flat, deep}, {x, y, z}, {}};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          bricks.count[axis] = (bricks.tiles[axis] + bricks.size[axis] - 1) / bricks.size[axis];
        }
        if (best.count[0] == 0 || cost(bricks) < cost(best)) best = bricks;
      }
    }
  }
  return best;
}

Layout::Layout(std::uint32_t blocks, std::uint32_t block_voxels) : bricks_(cut_block(block_voxels)) {
  const auto& [tiles, size, count] = bricks_;
  // Each brick takes the first page that is left in its bank.
  std::array<std::uint32_t, kBanksOfRank> next{0, 1, 2, 3};
  std::vector<std::uint32_t> page_of(std::size_t{count[0]} * count[1] * count[2]);
  for (std::uint32_t brick = 0; brick < page_of.size(); ++brick) {
    const std::uint32_t x = brick % count[0], y = brick / count[0] % count[1], z = brick / (count[0] * count[1]);
    std::uint32_t& page = next[(x + 2 * y + 3 * z) % kBanksOfRank];
    page_of[brick] = page;
    pages_ = std::max(pages_, page + 1);
    page += kBanksOfRank;
  }
  const std::uint64_t rows = (std::uint64_t{blocks} * pages_ + kBanksOfRank - 1) / kBanksOfRank;
  ranks_ = static_cast<std::uint32_t>(std::max<std::uint64_t>(1, (rows + kRows - 1) / kRows));
  const std::uint32_t all = tiles[0] * tiles[1] * tiles[2];
  places_.reserve(all);
  for (std::uint32_t tile = 0; tile < all; ++tile) {
    const std::uint32_t x = tile % tiles[0], y = tile / tiles[0] % tiles[1], z = tile / (tiles[0] * tiles[1]);
    const std::uint32_t brick = x / size[0] + count[0] * (y / size[1] + count[1] * (z / size[2]));
    const std::uint32_t column = x % size[0] + size[0] * (y % size[1] + size[1] * (z % size[2]));
    places_.push_back({static_cast<std::uint16_t>(page_of[brick]), static_cast<std::uint16_t>(column)});
  }
}

}  // namespace gicube::emu::ddr
