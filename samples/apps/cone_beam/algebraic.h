// Iterative reconstruction: each iteration projects the volume and backprojects the difference to the measured
// projections. All methods use gicube::Projector and take views on any orbit.
#pragma once

#include <cstdint>
#include <vector>

#include "cone_beam/view_rays.h"

namespace gicube::samples {

enum class Method {
  // They correct the volume after each view (Andersen and Kak 1984), after each subset, or after all views.
  kSart,
  kOsSart,
  kSirt,
  // Conjugate gradients of the normal equations (Hestenes and Stiefel 1952): the least residual of a number of
  // iterations.
  kCgls,
  kOsem,  // multiplies by the ratio of measured to projected values, after each subset (Hudson and Larkin 1994)
  // kOsSart, with steps that reduce the total variation after each iteration (Sidky and Pan 2008), for few views of
  // objects with flat parts. A step is `tv_weight` times the iteration's change at first, and less once the steps
  // change more than the iteration.
  kTv,
};

struct AlgebraicSettings {
  Method method = Method::kSart;
  int iterations = 10;  // at most, each through all views; at least 1
  int subsets = 10;     // kOsSart, kOsem, kTv: 2..views; a subset has every subsets-th view
  // > 0: factor of a correction; 1 would make its own projections right. Above 2 it finally diverges. Not for kCgls and
  // kOsem.
  double relaxation = 0.5;
  bool non_negative = true;  // values below 0 become 0 after each correction; kCgls keeps them
  // Per voxel, x fastest: not 0 where the object may be. The other voxels stay 0. Empty: everywhere.
  std::vector<std::uint8_t> mask{};
  int tv_steps = 20;        // kTv: steps after each iteration, 1..1000
  double tv_weight = 0.05;  // kTv: weight of a step, 0..1
  double stop = 0;          // ends when an iteration lowers the least residual by less than this part of it; 0: never
  // Ends when a residual is at most this, such as the noise of the measured projections (Morozov's discrepancy
  // principle): further iterations only fit the noise. 0: never.
  double noise = 0;
  double step = 1;  // 1/64..16 voxels between samples, of both directions
};

// The views of each subset.
std::vector<std::vector<std::size_t>> view_subsets(std::size_t views, const AlgebraicSettings& settings);
// Order of the subsets: each is about 0.62 of the scan's arc from the one before, because neighbours see nearly the
// same.
std::vector<std::size_t> subset_order(std::size_t subsets);

// Gradient of the total variation, the sum over voxels of the length of the differences to the next voxels on the axes.
std::vector<float> tv_gradient(const std::vector<float>& values, const Dims& dims);

// Starts from zero, kOsem from one value everywhere. It stops as diverged if a correction raises its own views'
// residual by 2% (checked once per iteration), if a residual is twice that of an empty volume, or after three
// iterations without a new least residual of which one is 2% above it. Returns the volume after the iteration with the
// least residual; zero if the first one diverged. A residual of kCgls is from after its iteration, and is computed from
// the earlier ones. Throws BadArgument (geometry, projections, settings), what the board throws.
Reconstruction reconstruct_algebraic(Board& board, const ConeGeometry& geometry, const Projections& projections,
                                     const AlgebraicSettings& settings = {}, const Progress& progress = {});

}  // namespace gicube::samples
