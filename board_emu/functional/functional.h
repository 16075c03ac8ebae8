// Traces one ray at the functional level: the pipeline's pure stages in a loop, without queues, caches or clocks.
//
// Input: a ray and the frame's constants. Output: the ray at its end. Rays do not depend on each other, so any number
// of threads gives the same bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

class SimdTracer;

// Traces `ray` from its position to its end: out of the volume, behind a cut plane, or opaque enough. It then holds its
// accumulated colour and opacity, and its end position, clamped to the volume. Routines must not scatter it. `steps`:
// null, or receives the number of steps, in a plain frame.
void integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps = nullptr);

// Traces rays that routines may scatter; trapped rays are collected and scattered together. Returns which rays have
// ended; the others wait for the host or for a block, in the frame's HostTrapQueue or WaitingRayQueue.
// `tracer`: null, or traces rays side by side, prepared for this frame.
// `indices`: of the rays in their source, for a frame in bricks.
std::vector<bool> integrate_all(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                                const SimdTracer* tracer = nullptr, std::span<const std::uint64_t> indices = {});

}  // namespace gicube::emu
