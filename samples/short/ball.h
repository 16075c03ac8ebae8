// A ball in a cube of bytes, for the short samples in which the volume does not matter.
#pragma once

#include <gicube/vector.h>

#include <algorithm>
#include <cstddef>
#include <vector>

// `edge` voxels along each axis. 128 on the surface, 32 more for each voxel inwards.
inline std::vector<std::byte> make_ball(int edge, double radius) {
  const double middle = (edge - 1) / 2.0;
  std::vector<std::byte> voxels;
  for (int z = 0; z < edge; ++z) {
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) {
        const double depth = radius - length(gicube::Vec3{x - middle, y - middle, z - middle});
        voxels.push_back(static_cast<std::byte>(std::clamp(128 + 32 * depth, 0.0, 255.0)));
      }
    }
  }
  return voxels;
}
