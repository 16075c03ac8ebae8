// The functional level's way for rays that backproject into sums: each ray is cut where it crosses blocks, the pieces are
// sorted by block, and threads take whole blocks, so that none waits for another and a block's words stay in a core's cache.
// The same sums as the cycle level's, sample by sample.
#pragma once

#include <span>

#include "datapath/frame.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

// Adds what the rays leave to frame.sums. The energy counters' `deposited.kept` is the signed sum of it, modulo 2^64. `steps`,
// if not empty: receives each ray's number of samples.
RayCounters backproject(std::span<const wire::Ray> rays, const Frame& frame, unsigned threads,
                        std::span<std::int32_t> steps = {});

}  // namespace gicube::emu
