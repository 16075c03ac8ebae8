// How far a reconstruction is from what it should be.
#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "cone_beam/geometry.h"

namespace gicube::samples {

// The voxels that are compared: those whose centre is so near to the axis of rotation and to the middle plane, in
// Grid::spacing's unit.
struct FieldOfView {
  double radius = std::numeric_limits<double>::infinity();
  double half_height = std::numeric_limits<double>::infinity();
};

struct Comparison {
  std::size_t voxels = 0;
  double rmse = 0;
  double bias = 0;         // mean of values less truth
  double relative_l2 = 0;  // rmse over the root mean square of the truth
  double psnr = 0;         // dB: 20 log10 (greatest - least of the truth / rmse); infinite if they are equal
  // Structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004) in three dimensions: its mean over the voxels, windows
  // being Gaussians of 1.5 voxels, of which at a volume's face there is only a part; K 0.01 and 0.03 of the truth's span.
  double ssim = 0;
};

// Both x fastest. Throws BadArgument (another number of values than voxels; a field of view without voxels).
Comparison compare(const Grid& grid, std::span<const float> values, std::span<const float> truth,
                   const FieldOfView& field = {});

// Values less truth, a voxel each.
std::vector<float> differences(std::span<const float> values, std::span<const float> truth);

// The values on the grid's line along `axis` (0, 1, 2) that runs through voxel `through`. Throws BadArgument.
std::vector<float> profile(const Grid& grid, std::span<const float> values, int axis, Dims through);

}  // namespace gicube::samples
