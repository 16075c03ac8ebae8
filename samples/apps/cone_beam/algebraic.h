// Algebraic reconstruction: the volume is projected, and what its projections miss of the measured ones is backprojected
// onto it, again and again; both by rays of the board.
#pragma once

#include <cstdint>
#include <vector>

#include "cone_beam/view_rays.h"

namespace gicube::samples {

// They differ in how many views are projected before the volume is corrected: one (Andersen and Kak 1984), some, all.
enum class Method { kSart, kOsSart, kSirt };

// In which order subsets take their turn within an iteration.
enum class ViewOrder {
  kSequential,  // by angle: neighbours follow each other, and learn little from each other
  kRandom,      // anew in each iteration
  kGolden,      // each about 0.62 of the scan's arc after the one before
};

struct AlgebraicSettings {
  Method method = Method::kSart;
  int iterations = 10;  // at most, each through all views; at least 1
  int subsets = 10;     // kOsSart: 2..views; every subsets-th view belongs to one
  // > 0: of a correction that would make the projections right if they were alone. Beyond 2 it diverges, sooner or later.
  double relaxation = 0.5;
  ViewOrder order = ViewOrder::kGolden;
  bool non_negative = true;  // values below 0 become 0 after each correction
  // Ends once an iteration lowers the least residual by less than this part of it; 0: never.
  double stop = 0;
  // Ends once a residual is no more than this, say the noise in the measured projections (Morozov's discrepancy principle):
  // beyond it the volume only learns their noise. 0: never.
  double noise = 0;
  double step = 1;         // 1/64..16 voxels between samples, of both directions
  std::uint64_t seed = 0;  // of kRandom
};

// How views fall into subsets, and which subset comes when.
std::vector<std::vector<std::size_t>> view_subsets(std::size_t views, const AlgebraicSettings& settings);
std::vector<std::size_t> subset_order(std::size_t subsets, const AlgebraicSettings& settings, int iteration);

// Begins with nothing. Divergence is a correction after which its own views' residual is 2% larger than before (looked at once an
// iteration), a residual twice that of nothing, or three iterations in a row without a new least residual, one of them 2% above
// it: it ends, and says so. What comes back is the volume after the iteration of the least residual; nothing if it diverged in the
// first.
// Throws BadArgument (geometry, projections, settings), what the board throws.
Reconstruction reconstruct_algebraic(Board& board, const ConeGeometry& geometry, const Projections& projections,
                                     const AlgebraicSettings& settings = {}, const Progress& progress = {});

}  // namespace gicube::samples
