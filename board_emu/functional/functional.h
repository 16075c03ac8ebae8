// One ray at the functional level: the pipeline's pure stages in a loop, without queues, caches or clocks.
//
// What enters: a ray and the frame's constants; what leaves: the ray as it ends. Nothing a ray computes depends on other
// rays, so any number of threads gives the same bits.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "functional/trail.h"
#include "gicube/wire/ray.h"

namespace gicube::emu {

class SimdTracer;

// Takes `ray` from its position to its end: out of the volume, behind a cut plane, or opaque enough. It then holds the colour
// and opacity that it gathered, and the position where it ended, clamped to the volume. No routine may scatter it. `steps`, if
// not null: receives the number of steps, in a plain frame.
void integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps = nullptr);

// The same for rays that routines may scatter: those that are trapped wait for one another, and are scattered together. Returns
// which came to their ends; the others wait for the host or for a block, and the frame's HostTrapQueue or WaitingRayQueue has them.
// `record`, if not null: receives the trail of each ray, in a frame that is not plain. `tracer`, if not null: prepared for this
// frame, takes the rays side by side. `indices`: which of their source's rays they are, for a frame in bricks.
std::vector<bool> integrate_all(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                                const TrailRecord* record = nullptr, const SimdTracer* tracer = nullptr,
                                std::span<const std::uint64_t> indices = {});

}  // namespace gicube::emu
