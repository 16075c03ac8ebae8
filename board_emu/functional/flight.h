// A ray on its way at the functional level, and one pass of it through the pipeline. Lanes of rays (functional/simd) take the
// passes in which nothing else happens than that a ray goes on; all others are taken here.
#pragma once

#include <cstddef>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "functional/trail.h"

namespace gicube::emu {

struct Flight {
  Flight(std::size_t its_ray, const RayState& as_it_begins) : ray(its_ray), ray_state(as_it_begins) {}

  std::size_t ray;  // its place among the rays that fly together
  RayState ray_state;
  Termination how = Termination::kNot;  // why it stands; kWaits: it is trapped
  Trap trap;                            // if it is trapped
};

// One pass of a ray that has not come to its end, in a frame that is not plain. kNot: it goes on. `trail`: null, or goes on as
// `record` says.
Termination take_pass(RayState& ray_state, const Frame& frame, RayCounters& counters, const TrailRecord* record,
                      RayTrail* trail);

// All passes, until the ray stands.
void fly(Flight& flight, const Frame& frame, RayCounters& counters, const TrailRecord* record);

}  // namespace gicube::emu
