// Splats pieces of backprojecting rays, each in one tile, by the host's vectors: the shares of trilinear_splat.h for several
// samples at once.
//
// A tile has eight words of 32 bits for each of its cells, the shares of the voxels around it: a sample's eight shares are one addition
// of vectors, and two samples that follow one another seldom meet in a cell. join() brings the cells to the voxels' words.
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
  std::int32_t amount = 0;  // of each sample
  Point first{};            // from the tile's corner
  Point step{};
  Rest rest{}, step_rest{};  // of the wide datapath, below the units of the first place and of the step
};

// Cells of a tile, x fastest: `across` along x and y, which is 8, 16, 32 or 64.
struct Tile {
  std::size_t across = 0;
  std::size_t depth = 0;

  std::size_t words() const { return 8 * across * across * depth; }
};

// Adds all samples of the pieces to the tile's cells. No word may leave its 32 bits.
void splat(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells);
// The same without vectors.
void splat_one_by_one(std::span<const Piece> pieces, const Tile& tile, std::int32_t* cells);

// Adds the cells to `words`, (across + 1)^2 a slice, and clears them. No voxel's sum in the tile may leave 32 bits.
void join(const Tile& tile, std::int32_t* cells, std::int64_t* words);
void join_one_by_one(const Tile& tile, std::int32_t* cells, std::int64_t* words);

}  // namespace gicube::emu
