// Backprojection into accumulators at the functional level: each ray is cut at the borders of tiles, which are slabs of
// blocks, the pieces are sorted by tile, and threads take whole tiles, so that they need no locks and a tile's words
// stay in a core's cache. The sums are those of the cycle level, which adds sample by sample.
#pragma once

#include <span>

#include "datapath/frame.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

// Queues the rays' contributions to frame.accumulators. The energy counters' `deposited.kept` is their signed sum,
// modulo 2^64.
RayCounters backproject(std::span<const wire::Ray> rays, const Frame& frame, unsigned threads);

}  // namespace gicube::emu
