// One iteration of a ray with a trace (functional_trace.h).
#pragma once

#include <algorithm>
#include <cstdint>

#include "datapath/interaction.h"

namespace gicube::emu {

// Advances a ray with a trace by one iteration: past its block if it `skips`, otherwise by one sample. `low` and
// `size`: the block's lowest corner and its edge.
inline void move_on(RayState& ray, const Point& low, std::int32_t size, bool skips, const Frame& frame,
                    RayCounters& counters) {
  const std::int32_t left = ray.steps_left();
  std::int32_t steps = 1;
  if (skips) {
    steps = skip_block(ray, low, size, frame, counters);
  } else {
    jitter_step(ray, frame);
    advance(ray, 1, frame);
    ++counters.samples;
  }
  ray.set_steps_left(left - std::min(steps, left));
}

}  // namespace gicube::emu
