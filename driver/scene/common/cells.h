// Iteration over a volume's voxels, cell by cell.
#pragma once

#include <algorithm>
#include <cstddef>

#include "gicube/parallel_for.h"
#include "gicube/vector.h"

namespace gicube::scene {

constexpr int kCell = 8;  // voxels; solids are searched once per cell

inline Vec3 middle_of_cell(const Dims& first) {
  return Vec3{double(first[0]), double(first[1]), double(first[2])} + 0.5 * (kCell - 1) * Vec3{1, 1, 1};
}

// Calls fill(first) for each cell's first voxel, on this number of threads (0: one per core).
template <typename Fill>
void each_cell(const Dims& dims, int threads, const Fill& fill) {
  parallel_for(static_cast<std::size_t>((dims[2] + kCell - 1) / kCell), static_cast<unsigned>(threads),
               [&](std::size_t layer) {
                 for (int y = 0; y < dims[1]; y += kCell) {
                   for (int x = 0; x < dims[0]; x += kCell) fill(Dims{x, y, static_cast<int>(layer) * kCell});
                 }
               });
}

inline std::size_t index_of(const Dims& dims, const Dims& at) {
  const auto across = static_cast<std::size_t>(dims[0]), down = static_cast<std::size_t>(dims[1]);
  return (static_cast<std::size_t>(at[2]) * down + static_cast<std::size_t>(at[1])) * across +
         static_cast<std::size_t>(at[0]);
}

// Calls visit(voxel, index) for each voxel, in the order of the indices.
template <typename Visit>
void each_voxel(const Dims& dims, const Visit& visit) {
  Dims at{};
  std::size_t index = 0;
  for (at[2] = 0; at[2] < dims[2]; ++at[2]) {
    for (at[1] = 0; at[1] < dims[1]; ++at[1]) {
      for (at[0] = 0; at[0] < dims[0]; ++at[0]) visit(at, index++);
    }
  }
}

// Calls visit(p, index) for each of a cell's voxels.
template <typename Visit>
void each_voxel(const Dims& dims, const Dims& first, const Visit& visit) {
  for (int z = first[2]; z < std::min(first[2] + kCell, dims[2]); ++z) {
    for (int y = first[1]; y < std::min(first[1] + kCell, dims[1]); ++y) {
      const std::size_t row = index_of(dims, {0, y, z});
      for (int x = first[0]; x < std::min(first[0] + kCell, dims[0]); ++x) {
        visit(Vec3{double(x), double(y), double(z)}, row + static_cast<std::size_t>(x));
      }
    }
  }
}

}  // namespace gicube::scene
