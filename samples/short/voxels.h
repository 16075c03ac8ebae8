// Voxels of a formula for the short samples.
#pragma once

#include <gicube/vector.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

// `formula(place)` at each voxel, x fastest.
template <typename Value = float, typename Formula>
std::vector<Value> make_voxels(const std::array<int, 3>& dims, const Formula& formula) {
  std::vector<Value> voxels;
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) {
        voxels.push_back(static_cast<Value>(formula(gicube::Vec3{double(x), double(y), double(z)})));
      }
    }
  }
  return voxels;
}

// A ball in `edge` voxels along each axis: 128 on the surface, 32 more per voxel inwards.
inline std::vector<std::byte> make_ball(int edge, double radius) {
  const double middle = (edge - 1) / 2.0;
  return make_voxels<std::byte>({edge, edge, edge}, [&](gicube::Vec3 place) {
    const double depth = radius - length(place - gicube::Vec3{middle, middle, middle});
    return std::clamp(128 + 32 * depth, 0.0, 255.0);
  });
}
