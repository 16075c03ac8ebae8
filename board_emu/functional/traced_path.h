// A ray under way at the functional level, and its iterations through the pipeline. Lanes of rays (functional/simd) do
// the iterations in which a ray only continues; all others are done here.
#pragma once

#include <cstddef>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"

namespace gicube::emu {

struct TracedPath {
  TracedPath(std::size_t its_ray, const RayState& as_it_begins) : ray(its_ray), ray_state(as_it_begins) {}

  std::size_t ray;  // index among the rays that are traced together
  RayState ray_state;
  Termination how = Termination::kActive;  // why it has stopped; kWaits: it is trapped
  Trap trap;                               // if it is trapped
};

// One iteration of a ray that has not ended, in a frame that is not plain. kActive: it continues. `known`: null, or
// what lanes know of the sample that it takes.
Termination take_iteration(RayState& ray_state, const Frame& frame, RayCounters& counters, const KnownInterval* known);

// All iterations until the ray stops.
void trace_path(TracedPath& path, const Frame& frame, RayCounters& counters);

}  // namespace gicube::emu
