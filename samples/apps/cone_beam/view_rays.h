// A geometry's projector, and what a reconstruction brings back.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cone_beam/geometry.h"
#include "gicube/board.h"

namespace gicube::samples {

// A projector of all views, with so many rays per pixel: the detector's pixels are replaced by finer ones. Throws
// BadArgument (geometry, step).
Projector projector_of(Board& board, const ConeGeometry& geometry, double step, PixelRays of_pixel = {});

// All views of a volume with geometry.volume's voxels, x fastest. What lies outside of it is nothing.
// Throws BadArgument (geometry, volume, step), what the board throws.
Projections project_by_board(Board& board, const ConeGeometry& geometry, std::span<const float> volume,
                             double step = 0.5, const Progress& progress = {});

// The result of a reconstruction, by any method.
struct Reconstruction {
  std::vector<float> values;  // of geometry.volume, x fastest
  std::uint64_t rays = 0;     // of both directions
  std::uint64_t deposits = 0;
  std::uint64_t overflowed = 0;  // sums that were full: the values are wrong there
  double clipped = 0;  // of what was left in irradiance words, the share that full ones lost: values are wrong by it
  Picoseconds board_time = 0;  // simulated, from the first ray to the last value read

  // Algebraic methods only. The root of the sum of (measured - projected)^2 over that of measured^2, one an iteration,
  // of each view before it was corrected for.
  std::vector<double> residuals{};
  int iterations = 0;     // whole ones; `values` are those after the one with the least residual
  bool diverged = false;  // the residual grew: the relaxation is too large
};

// The densities that a view's rays leave in a unit of volume, in the order of Projector::rays().
using ViewDensities = Projector::ViewValues;

// Backprojects all views, makes up for faces, and adds what the projector counts to `counts`.
std::vector<float> backproject(Projector& projector, double max_density, const ViewDensities& densities,
                               Reconstruction& counts);

// Doubles the sums of voxels on the volume's faces (edges, corners: 4, 8 times), which only rays on one side of them
// reach.
void make_up_for_faces(std::vector<float>& sums, const Dims& dims);

}  // namespace gicube::samples
