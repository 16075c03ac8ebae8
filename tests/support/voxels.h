// The voxels of a volume in the order of its samples.
#pragma once

#include <array>

namespace gicube {

// Calls use(x, y, z) for each voxel, x fastest.
template <typename Use>
void for_each_voxel(const std::array<int, 3>& dims, const Use& use) {
  for (int z = 0; z < dims[2]; ++z) {
    for (int y = 0; y < dims[1]; ++y) {
      for (int x = 0; x < dims[0]; ++x) use(x, y, z);
    }
  }
}

}  // namespace gicube
