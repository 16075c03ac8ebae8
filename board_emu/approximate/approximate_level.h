// The approximate level carries out DSP commands of rays that only gather: values as the functional level, time by the turns
// that the rays take (turn_machine.h).
#pragma once

#include <span>

#include "cycle/cycle_level.h"
#include "firmware/framebuffer.h"
#include "gicube/wire/command.h"
#include "functional/simd/simd_tracer.h"
#include "pass_machine.h"

namespace gicube::emu {

// Both: `frame` is plain; `packets` made ready for it, or null; what its rays do is added to `counters`.

// Fills `framebuffer` with the image of `command`.
Ran render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer, const v1::DspConfig& dsp,
           const RayPackets* packets, unsigned threads, TurnMachine& machine, RayCounters& counters, Work& work);

// Takes rays to their ends.
Ran trace(const GivenRays& rays, const Frame& frame, const RayPackets* packets, unsigned threads, TurnMachine& machine,
          RayCounters& counters, Work& work);

}  // namespace gicube::emu
