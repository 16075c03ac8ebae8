// Makes a coarser version of a block, for pictures in which a pixel is as wide as several voxels [P §5.3].
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "encode/volume/gradients.h"
#include "gicube/vector.h"

namespace gicube {

struct CoarseBlock {
  // Bytes of the command kLoadCoarse: words of the cells, and their colours.
  std::vector<std::uint8_t> packed;
  int largest_error = 0;  // of a voxel's density, 4095 = the value range
};

// `packed`: n^3 words, and their colours if `coloured`. `inside`: how many voxels of the block are inside the volume
// along each axis. A cell has an edge of 2^level voxels; its density and colour are their means, its tag the most
// frequent one (the lowest of equals), its gradient the direction of the sum of theirs.
CoarseBlock coarse_block(std::span<const std::uint8_t> packed, std::size_t n, const Dims& inside, bool coloured,
                         int level, const GradientCodebook& codebook);

}  // namespace gicube
