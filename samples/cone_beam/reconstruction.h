// What a reconstruction brings back, by whichever method.
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/time.h"

namespace gicube::samples {

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
  int iterations = 0;     // whole ones; `values` are those after the one with the least residual
  bool diverged = false;  // the residual grew: the relaxation is too large
};

}  // namespace gicube::samples
