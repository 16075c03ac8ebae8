// The rays of views: what they integrate of a volume on the board, and what they leave in its sums.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "cone_beam/geometry.h"
#include "gicube/board.h"

namespace gicube::samples {

// The piece of a ray that runs through the volume, in voxels, clipped to the box of voxel centres; no length: none.
HostRay clipped_ray(const Grid& grid, Vec3 source, Vec3 pixel);
// The rays of all pixels, rows first, clipped to the volume; a ray that misses it has no length.
std::vector<HostRay> view_rays(const ConeGeometry& geometry, double angle, PixelRays of_pixel = {});
// In the unit of grid.spacing; 0 of a ray of no length.
double length_in_space(const Grid& grid, const HostRay& ray);

// Brings one value per voxel onto the board, in 12 bits between the least (at most 0) and the greatest of them. Sums that the
// board holds are lost. Throws BadArgument (another number of values than voxels, one that is not finite).
void load_values(Board& board, const Grid& grid, std::span<const float> values);

// Integrates what load_values() brought along the rays of each of `angles`, samples at most `step` voxels apart, 1/64..16, and calls
// take(view, line integrals of the pixels) in this order. Returns the number of rays. The board works at the next view while one
// is received.
std::uint64_t project_views(Board& board, const ConeGeometry& geometry, std::span<const double> angles, double step,
                            const std::function<void(std::size_t view, const std::vector<float>& values)>& take);

// All views of a volume with geometry.volume's voxels, x fastest. What lies outside of it is nothing.
// Throws BadArgument (geometry, volume, step), what the board throws.
Projections project_by_board(Board& board, const ConeGeometry& geometry, std::span<const float> volume,
                             double step = 0.5, const Progress& progress = {});

// What a reconstruction brings back, by whichever method.
struct Reconstruction {
  std::vector<float> values;  // of geometry.volume, x fastest
  std::uint64_t rays = 0;     // of both directions
  std::uint64_t deposits = 0;
  std::uint64_t overflowed = 0;  // sums that were full: the values are wrong there
  double clipped = 0;  // of what was left in irradiance words, the share that full ones lost: values are wrong by it
  Picoseconds board_time = 0;  // simulated, from the first ray to the last value read

  // Algebraic methods only. The root of the sum of (measured - projected)^2 over that of measured^2, one an iteration, of
  // each view before it was corrected for.
  std::vector<double> residuals{};
  std::vector<Picoseconds> iteration_ends{};  // simulated, from the first ray: when each of these iterations was done
  int iterations = 0;                         // whole ones; `values` are those after the one with the least residual
  bool diverged = false;                      // the residual grew: the relaxation is too large
};

// The densities that a view's rays leave in a unit of volume, in the order of view_rays().
using ViewDensities = std::function<std::vector<double>(std::size_t view)>;

struct Splatting {
  PixelRays rays{};
  double step = 1;         // voxels between deposits, 1/64..16
  double max_density = 0;  // the largest |density| of any ray: it fixes the unit of the sums, with the number of views
};

// Clears the board's sums, leaves each ray's density times its length in the voxels on its way, and reads the sums; those of voxels
// on the volume's faces, which only rays on one side of them reach, are made up for. Adds rays, deposits and overflows to `counts`.
std::vector<float> backproject(Board& board, const ConeGeometry& geometry, std::span<const double> angles,
                               const Splatting& how, const ViewDensities& densities, Reconstruction& counts);

// An upper bound of what a voxel near the source receives from one view that leaves a density of 1.
double max_of_a_voxel(const ConeGeometry& geometry, PixelRays rays);
// Doubles the sums of voxels on the volume's faces (edges, corners: 4, 8 times), which only rays on one side of them reach.
void make_up_for_faces(std::vector<float>& sums, const Dims& dims);

}  // namespace gicube::samples
