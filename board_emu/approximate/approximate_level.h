// The approximate level carries out DSP commands of rays that only gather: values as the functional level, time by the turns
// that the rays take (pass_machine.h).
#pragma once

#include <span>

#include "cycle/cycle_level.h"
#include "firmware/framebuffer.h"
#include "functional/simd/simd_tracer.h"
#include "gicube/wire/command.h"
#include "pass_machine.h"

namespace gicube::emu {

// Both: `frame` is plain; `packets` made ready for it, or null; what its rays do is added to `counters`.

// Fills `framebuffer` with the image of `command`.
RunResult render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                 const v1::DspConfig& dsp, const SimdTracer* packets, unsigned threads, PassMachine& machine,
                 RayCounters& counters, Progress& work);

// Takes rays to their ends.
RunResult trace(const GivenRayBatch& rays, const Frame& frame, const SimdTracer* packets, unsigned threads,
                PassMachine& machine, RayCounters& counters, Progress& work);

}  // namespace gicube::emu
