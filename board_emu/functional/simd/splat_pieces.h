// Splats pieces of backprojecting rays, each in one tile, with the host's vectors: the shares of trilinear_splat.h for
// several samples at once. Amounts of more than 16 bits are splatted one by one; the driver's Projector has none.
//
// A tile has eight words of 32 bits per cell, the shares of the voxels around it: a sample's eight shares are one
// vector addition, and consecutive samples seldom use the same cell. join() adds the cells to the voxels' words.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "datapath/advance.h"
#include "words/words.h"

namespace gicube::emu {

// A ray's samples in one tile.
struct Piece {
  std::uint32_t count = 0;
  std::int32_t amount = 0;  // per sample
  Point first{};            // relative to the tile's corner
  Point step{};
  Rest rest{}, step_rest{};  // bits below the units of `first` and `step`
  bool wide = false;         // whether they count; else they are 0
};

// The cells of a tile, x fastest. `across`: along x and y, 8, 16, 32 or 64.
struct Tile {
  std::size_t across = 0;
  std::size_t depth = 0;

  std::size_t words() const { return 8 * across * across * depth; }
};

// Adds all samples of the pieces to the tile's cells. No word may exceed 32 bits.
void splat(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells);
// splat() without vectors.
void splat_one_by_one(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells);

// Adds the cells to `words`, (across + 1)^2 per slice, and clears them. No voxel's sum in the tile may exceed 32 bits.
void join(const Tile& tile, std::int32_t* cells, std::int64_t* words);
void join_one_by_one(const Tile& tile, std::int32_t* cells, std::int64_t* words);

}  // namespace gicube::emu
