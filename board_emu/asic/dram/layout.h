// The division of a block of n^3 voxels with its +1 faces into pages (rows of a bank). A page holds a brick of
// neighbouring tiles, so that coherent rays hit open rows whatever their direction.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace gicube::emu::dram {

// Packets of a tile of 2 x 2 x 1 voxels. A packet has 144 bits: sixteen bytes of nine bits.
constexpr std::uint32_t packets_of_tile(std::uint32_t voxel_bits) { return (4 * voxel_bits + 143) / 144; }

struct Bricks {
  std::array<std::uint32_t, 3> tiles{};  // tiles of the block, per axis: n/2 + 1, n/2 + 1, n + 1
  std::array<std::uint32_t, 3> size{};   // tiles of a brick, per axis
  std::array<std::uint32_t, 3> count{};  // bricks, per axis
  std::uint32_t pages = 0;               // pages of a block: one per brick

  // A tile's brick, and its column in the brick's page.
  struct BrickColumn {
    std::array<std::uint32_t, 3> brick;
    std::uint16_t column;
  };
  std::uint32_t all_tiles() const { return tiles[0] * tiles[1] * tiles[2]; }
  BrickColumn column_of(std::uint32_t tile) const {
    const std::uint32_t x = tile % tiles[0], y = tile / tiles[0] % tiles[1], z = tile / (tiles[0] * tiles[1]);
    const std::uint32_t column = x % size[0] + size[0] * (y % size[1] + size[1] * (z % size[2]));
    return {{x / size[0], y / size[1], z / size[2]}, static_cast<std::uint16_t>(column)};
  }
  // Pages of a block, which measure its memory, times the surface of a brick in voxel faces (a tile is 2 x 2 x 1
  // voxels), which measures how many pages coherent rays have open at once.
  std::uint32_t cost() const {
    const std::uint32_t x = 2 * size[0], y = 2 * size[1], z = size[2];
    return pages * (x * y + y * z + z * x);
  }
};

// The cheapest bricks for which `accepted` is true. `standard`: its name for the error message. `row`: tiles of a page.
template <typename Accepted>
Bricks cut_block(const char* standard, std::uint32_t block_voxels, std::uint32_t row, const Accepted& accepted) {
  if (block_voxels < 2 || block_voxels > 64 || block_voxels % 2 != 0) {
    throw std::invalid_argument(std::string("block of the ") + standard +
                                " layout: expected an even 2 to 64 voxels, got " + std::to_string(block_voxels));
  }
  const std::uint32_t flat = block_voxels / 2 + 1, deep = block_voxels + 1;
  std::vector<Bricks> all;
  for (std::uint32_t x = 1; x <= std::min(flat, row); ++x) {
    for (std::uint32_t y = 1; y <= std::min(flat, row / x); ++y) {
      for (std::uint32_t z = 1; z <= std::min(deep, row / (x * y)); ++z) {
        Bricks bricks{{flat, flat, deep}, {x, y, z}, {}, 1};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          bricks.count[axis] = (bricks.tiles[axis] + bricks.size[axis] - 1) / bricks.size[axis];
          bricks.pages *= bricks.count[axis];
        }
        all.push_back(bricks);
      }
    }
  }
  std::ranges::stable_sort(all, {}, &Bricks::cost);  // few are asked whether they are accepted, which takes long
  const auto best = std::ranges::find_if(all, accepted);
  return best == all.end() ? Bricks() : *best;
}

// Base of the layouts of all standards.
class LayoutBase {
 public:
  std::uint32_t devices() const { return devices_; }  // devices of a channel, at least 1
  std::uint32_t tiles() const { return static_cast<std::uint32_t>(columns_.size()); }  // of a block
  const Bricks& bricks() const { return bricks_; }
  std::uint32_t packets_of_tile() const { return packets_; }

 protected:
  struct PageColumn {
    std::uint16_t page;
    std::uint16_t column;
  };
  // `packets`: those of a tile.
  LayoutBase(const Bricks& bricks, std::uint32_t packets) : bricks_(bricks), packets_(packets) {}

  // The column of a tile's first packet.
  std::uint16_t first_column(std::uint16_t column) const { return static_cast<std::uint16_t>(column * packets_); }

  Bricks bricks_;
  std::uint32_t packets_;
  std::uint32_t devices_ = 1;
  std::vector<PageColumn> columns_;  // by tile, x fastest
};

}  // namespace gicube::emu::dram
