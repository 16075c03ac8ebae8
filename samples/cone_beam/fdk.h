// Filtered backprojection by the board: the method of Feldkamp, Davis and Kress (1984), its backprojection by
// energy-depositing rays that nothing weakens [P §5.6]. docs/CONE_BEAM.md derives the weights.
#pragma once

#include <functional>
#include <vector>

#include "cone_beam/filter.h"
#include "cone_beam/geometry.h"
#include "gicube/board.h"

namespace gicube::samples {

struct FdkSettings {
  Window window = Window::kRamLak;
  int rays = 1;     // 1..4: a pixel's along each detector axis
  double step = 1;  // 1/64..16 voxels between deposits
  // 0..1/4: what each voxel takes from either neighbour on an axis, against the blur of splatting. 1/12 gives back what that
  // adds to the width of a structure, a little more suits edges (docs/CONE_BEAM.md); much more sharpens ripples too.
  double sharpen = 0.1;
};

struct Reconstruction {
  std::vector<float> values;  // of geometry.volume, x fastest
  std::uint64_t rays = 0;
  std::uint64_t deposits = 0;
  std::uint64_t overflowed = 0;  // sums that were full: the values are wrong there
  Picoseconds board_time = 0;    // simulated, from the first ray to the last value read
};

// One view's projections, cosine-weighted, of short scans shared out, and filtered: what the rays of fine x fine a pixel leave
// in a unit of volume. Rows first, each of fine x columns.
std::vector<double> filtered_view(const Projections& projections, const ConeGeometry& geometry, std::size_t view,
                                  const RampFilter& filter, int fine);
RampFilter ramp_filter(const ConeGeometry& geometry, Window window, int fine);

// v (1 + 2 part) - part (both neighbours), along each axis; the ends are their own neighbours.
void sharpen(std::vector<float>& values, const Dims& dims, double part);

// Loads an empty volume of geometry.volume's dims into the board, and leaves the sums there.
// Throws BadArgument (geometry, projections, settings), what the board throws.
Reconstruction reconstruct_fdk(Board& board, const ConeGeometry& geometry, const Projections& projections,
                               const FdkSettings& settings = {}, const Progress& progress = {});

}  // namespace gicube::samples
