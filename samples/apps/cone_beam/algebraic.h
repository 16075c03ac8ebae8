// Iterative reconstruction: the volume is projected, and what its projections miss of the measured ones is
// backprojected onto it, again and again. All methods are a few lines each on gicube::Projector, and take views on any
// orbit.
#pragma once

#include <cstdint>
#include <vector>

#include "cone_beam/view_rays.h"

namespace gicube::samples {

enum class Method {
  // They differ in how many views are projected before the volume is corrected: one (Andersen and Kak 1984), some, all.
  kSart,
  kOsSart,
  kSirt,
  // Conjugate gradients of the normal equations (Hestenes and Stiefel 1952): the least residual for a number of
  // iterations.
  kCgls,
  kOsem,  // multiplies by the ratio of measured to projected, some views at a time (Hudson and Larkin 1994)
  // kOsSart, and after each iteration steps down the total variation, at first of `tv_weight` times what the iteration
  // has changed, less as soon as they change more than that (Sidky and Pan 2008): from few views, of objects with flat
  // parts.
  kTv,
};

struct AlgebraicSettings {
  Method method = Method::kSart;
  int iterations = 10;  // at most, each through all views; at least 1
  int subsets = 10;     // kOsSart, kOsem, kTv: 2..views; every subsets-th view belongs to one
  // > 0: of a correction that would make the projections right if they were alone. Beyond 2 it diverges, sooner or
  // later. Not of kCgls and kOsem.
  double relaxation = 0.5;
  bool non_negative = true;  // values below 0 become 0 after each correction; kCgls leaves them
  // Where the object may be: of each voxel, x fastest, not 0. The others stay 0. Empty: everywhere.
  std::vector<std::uint8_t> mask{};
  int tv_steps = 20;        // kTv: after each iteration, 1..1000
  double tv_weight = 0.05;  // kTv: of a step, 0..1
  // Ends once an iteration lowers the least residual by less than this part of it; 0: never.
  double stop = 0;
  // Ends once a residual is no more than this, say the noise in the measured projections (Morozov's discrepancy
  // principle): beyond it the volume only learns their noise. 0: never.
  double noise = 0;
  double step = 1;  // 1/64..16 voxels between samples, of both directions
};

// The views of each subset.
std::vector<std::vector<std::size_t>> view_subsets(std::size_t views, const AlgebraicSettings& settings);
// The order in which subsets take their turn: each is about 0.62 of the scan's arc from the one before, since
// neighbours see nearly the same.
std::vector<std::size_t> subset_order(std::size_t subsets);

// The gradient of the total variation (the sum of the lengths of differences to the next voxels on the axes) by each
// voxel.
std::vector<float> tv_gradient(const std::vector<float>& values, const Dims& dims);

// Begins with nothing, kOsem with one value everywhere. Divergence is a correction after which its own views' residual
// is 2% larger than before (looked at once an iteration), a residual twice that of nothing, or three iterations in a
// row without a new least residual, one of them 2% above it: it ends, and says so. What comes back is the volume after
// the iteration of the least residual; nothing if it diverged in the first. A residual of kCgls is that after its
// iteration, and follows from the ones before.
// Throws BadArgument (geometry, projections, settings), what the board throws.
Reconstruction reconstruct_algebraic(Board& board, const ConeGeometry& geometry, const Projections& projections,
                                     const AlgebraicSettings& settings = {}, const Progress& progress = {});

}  // namespace gicube::samples
