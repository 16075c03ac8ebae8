// Splats pieces of backprojecting rays, each in one block, by the host's vectors: the shares of trilinear_splat.h for several
// samples at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "datapath/advance.h"
#include "words/words.h"

namespace gicube::emu {

// A ray's samples in one block.
struct Piece {
  std::uint32_t block = 0;
  std::uint32_t count = 0;
  Point first{};  // from the block's corner
  Point step{};
  std::int32_t amount = 0;   // of each sample
  Rest rest{}, step_rest{};  // of the wide datapath, below the units of the first place and of the step
};

// Adds all samples of the pieces to `pairs` (SumMemory::pairs()) of their block. `row`, `slice`: from a voxel to the next in y
// and z.
void splat(std::span<const Piece> pieces, std::int64_t* pairs, std::size_t row, std::size_t slice);
// The same to words, which hold more.
void splat_to_words(std::span<const Piece> pieces, std::int64_t* words, std::size_t row, std::size_t slice);

// The first without vectors.
void splat_one_by_one(std::span<const Piece> pieces, std::int64_t* pairs, std::size_t row, std::size_t slice);

}  // namespace gicube::emu
