// A geometry's projector, and the result of a reconstruction.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cone_beam/geometry.h"
#include "gicube/board.h"

namespace gicube::samples {

// Makes a projector of all views. Several rays per pixel replace the detector's pixels by finer ones. Throws
// BadArgument (geometry, step).
Projector projector_of(Board& board, const ConeGeometry& geometry, double step, PixelRays of_pixel = {});

// Projects all views of a volume with geometry.volume's voxels, x fastest. Outside the volume the values are 0. Throws
// BadArgument (geometry, volume, step), what the board throws.
Projections project_by_board(Board& board, const ConeGeometry& geometry, std::span<const float> volume,
                             double step = 0.5, const Progress& progress = {});

// The result of a reconstruction, by any method.
struct Reconstruction {
  std::vector<float> values;  // of geometry.volume, x fastest
  std::uint64_t rays = 0;     // of both directions
  std::uint64_t deposits = 0;
  std::uint64_t overflowed = 0;  // full sums: their values are wrong
  double clipped = 0;  // share of the deposits that full irradiance words lost: the relative error of the values
  Picoseconds board_time = 0;  // simulated, from the first ray to the last value read

  // Algebraic methods only. Per iteration the root of the sum of (measured - projected)^2 over that of measured^2; each
  // view's part is from before its correction.
  std::vector<double> residuals{};
  int iterations = 0;     // complete ones; `values` are from the one with the least residual
  bool diverged = false;  // the residual grew: the relaxation is too large
};

// Densities that a view's rays deposit per unit of volume, in the order of Projector::rays().
using ViewDensities = Projector::ViewValues;

// Backprojects all views, makes up for faces, and copies the projector's counts to `counts`.
std::vector<float> backproject(Projector& projector, double max_density, const ViewDensities& densities,
                               Reconstruction& counts);

// Doubles the sums of voxels on the volume's faces (edges, corners: 4, 8 times), because only rays on one side of them
// reach them.
void make_up_for_faces(std::vector<float>& sums, const Dims& dims);

}  // namespace gicube::samples
