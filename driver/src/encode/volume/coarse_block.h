// A block in fewer voxels, for what is seen from so far away that a pixel is as wide as several of them [P §5.3].
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

// `packed`: n^3 words, and their colours if `coloured`, of which `inside` are in the volume along each axis. A cell of
// 2^level voxels an edge has the mean of their densities, and of their colours; the tag that most of them have, the
// lowest of equals; and the gradient of the sum of theirs.
CoarseBlock coarse_block(std::span<const std::uint8_t> packed, std::size_t n, const Dims& inside, bool coloured,
                         int level, const GradientCodebook& codebook);

}  // namespace gicube
