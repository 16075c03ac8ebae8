#include "form_factors/radiosity.h"

namespace gicube::samples {

std::array<int, 3> voxel_behind(const Leaf& leaf) {
  std::array<int, 3> voxel = leaf.cell;
  if (leaf.facing < kMedium) voxel[leaf.facing / 2u] += leaf.facing % 2 == 0 ? 1 : -1;
  return voxel;
}

}  // namespace gicube::samples
