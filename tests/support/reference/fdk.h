// Filtered backprojection of cone-beam projections in double precision, voxel by voxel: for each voxel and view the
// filtered projection where the ray through the voxel meets the detector, between four pixels. Plain and slow; it
// shares no code with what it judges but the records of geometry and projections.
#pragma once

#include <cmath>
#include <vector>

#include "cone_beam/geometry.h"

namespace gicube::reference {

enum class Kernel { kRamLak, kSheppLogan, kHann };

// Rows of one view after weighting and convolution, in space, with the kernel's closed form.
std::vector<double> filter_rows(const samples::ConeGeometry& geometry, const samples::Projections& projections,
                                std::size_t view, Kernel kernel);

// One value a voxel, x fastest.
std::vector<double> reconstruct(const samples::ConeGeometry& geometry, const samples::Projections& projections,
                                Kernel kernel = Kernel::kRamLak);

// Root mean square and mean of the differences over voxels whose centre is within `radius` of the axis and
// `half_height` of the middle plane.
struct Difference {
  double rmse = 0;
  double bias = 0;  // values less truth
};
template <typename Values, typename Truth>
Difference difference(const samples::Grid& grid, const Values& values, const Truth& truth, double radius,
                      double half_height) {
  double squares = 0, sum = 0, count = 0;
  std::size_t i = 0;
  for (int z = 0; z < grid.dims[2]; ++z) {
    for (int y = 0; y < grid.dims[1]; ++y) {
      for (int x = 0; x < grid.dims[0]; ++x, ++i) {
        const Vec3 at =
            samples::to_space(grid, {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
        if (std::hypot(at.x, at.y) > radius || std::abs(at.z) > half_height) continue;
        const double off = static_cast<double>(values[i]) - static_cast<double>(truth[i]);
        squares += off * off;
        sum += off;
        ++count;
      }
    }
  }
  return {std::sqrt(squares / count), sum / count};
}

}  // namespace gicube::reference
