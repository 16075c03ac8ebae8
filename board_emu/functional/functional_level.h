// The functional level carries out DSP commands: it makes rays, takes each through the pipeline, and gathers them.
//
// Rays are spread over host threads; what they compute does not depend on it.
#pragma once

#include <cstdint>
#include <span>

#include "board/board.h"
#include "datapath/frame.h"
#include "firmware/framebuffer.h"
#include "firmware/lighting_rays.h"
#include "functional/simd/simd_tracer.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

struct Rendered {
  std::uint64_t made = 0;      // viewing or lighting rays
  std::uint64_t returned = 0;  // those of them that entered the volume and came back
  RayCounters rays;
  bool cancelled = false;
};

// `packets`, here and below: made ready for this frame, or null.

// Fills `framebuffer` with the image of `command`. Progress is in tiles of pixels.
Rendered render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                const SimdTracer* packets, unsigned threads, Progress& work);

// Sends the lighting rays of `rays` into the volume, each with the frame's lifetime. Progress is in runs of rays.
Rendered illuminate(const LightingRays& rays, const Frame& frame, unsigned threads, Progress& work);

// Rays that the host has scattered (trap.h) go on: lighting rays, or rendering rays into `framebuffer`. Of the counters
// energy.emitted is what they bring.
Rendered resume(std::span<const wire::Ray> answers, const Frame& frame, Framebuffer& framebuffer, unsigned threads,
                Progress& work);

// Takes rays to their ends, in place. One that lies behind a cut plane stays as it is. Of the counters
// energy.emitted is what lighting rays bring. `steps`, if there are any, of a plain frame: of each ray, on its way.
RayCounters trace(std::span<wire::Ray> rays, const Frame& frame, const SimdTracer* packets, unsigned threads,
                  std::span<std::int32_t> steps = {});

}  // namespace gicube::emu
