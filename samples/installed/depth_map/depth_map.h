// Depth maps: how far a surface in a volume lies behind each pixel.
#pragma once

#include <gicube/board.h>

#include <vector>

namespace example {

struct DepthMap {
  int width = 0;
  int height = 0;
  std::vector<float> depths;  // voxels from the volume's front face, rows from the top; negative: no surface there
};

// A cube of `edge` voxels with a ball of `radius` voxels in its middle, whose surface has the value 128.
std::vector<std::byte> ball(int edge, double radius);

// Loads such a volume, and makes everything from the value 128 on opaque.
void load(gicube::Board& board, const std::vector<std::byte>& voxels, int edge);

// One ray along z for each pixel, a row a batch, to the first sample on the surface or behind it. Up to `in_flight`
// batches are on their way at once; with each that has come back the host works for `host_time` while the board goes
// on.
DepthMap depth_map(gicube::Board& board, int edge, int width, int height, int in_flight,
                   gicube::Picoseconds host_time = 0);

}  // namespace example
