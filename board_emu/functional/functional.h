// Traces one ray at the functional level: the pipeline's pure stages in a loop, without queues, caches or clocks.
//
// Input: a ray and the frame's constants. Output: the ray at its end. Rays do not depend on each other, so any number
// of threads gives the same bits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "datapath/interaction.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

class SimdTracer;

// A ray under way. Lanes of rays (functional/simd) do the iterations in which it only continues; the functions below do
// all others.
struct TracedPath {
  TracedPath(std::size_t its_ray, const RayState& as_it_begins) : ray(its_ray), ray_state(as_it_begins) {}

  std::size_t ray;  // index among the rays that are traced together
  RayState ray_state;
  Termination how = Termination::kActive;  // why it has stopped; kWaits: it is trapped
  Trap trap;                               // if it is trapped
};

// One iteration of a ray that has not ended, in a frame that is not plain. kActive: it continues. `known`: null, or
// what lanes have computed of the sample that it takes.
Termination take_iteration(RayState& ray_state, const Frame& frame, RayCounters& counters, const KnownInterval* known);

// All iterations until the ray stops.
void trace_path(TracedPath& path, const Frame& frame, RayCounters& counters);

// Traces `ray` from its position to its end: out of the volume, behind a cut plane, or opaque enough. It then holds its
// accumulated colour and opacity, and its end position, clamped to the volume. Routines must not scatter it. `steps`:
// null, or receives the number of steps, in a plain frame.
void integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps = nullptr);

// Traces rays that routines may scatter; trapped rays are collected and scattered together. Returns which rays have
// ended; the others wait for the host or for a block, in the frame's HostTraps or WaitingRays.
// `tracer`: null, or traces rays side by side, prepared for this frame.
// `indices`: of the rays in their source, for a frame in bricks.
std::vector<bool> integrate_all(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                                const SimdTracer* tracer = nullptr, std::span<const std::uint64_t> indices = {});

}  // namespace gicube::emu
