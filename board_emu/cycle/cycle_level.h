// The cycle level carries out DSP commands: the same rays as the functional level's, sent through the machine.
#pragma once

#include <span>

#include "firmware/framebuffer.h"
#include "firmware/lighting_rays.h"
#include "gicube/wire/command.h"
#include "machine.h"

namespace gicube::emu {

// Fills `framebuffer` with the image of `command`, rays in rows from the top. Throws Stall.
RunResult render(const wire::RenderCommand& command, const Frame& frame, Framebuffer& framebuffer,
                 const v1::DspConfig& dsp, Machine& machine, Progress& work);

struct Lit {
  std::uint64_t made = 0;     // lighting rays
  std::uint64_t emitted = 0;  // by them, energy units
};

// Sends the lighting rays of `rays` into the volume. Throws Stall and RoutineFault.
RunResult illuminate(const LightingRays& rays, const Frame& frame, const v1::DspConfig& dsp, Machine& machine, Lit& lit,
                     Progress& work);

// Rays that the host has scattered (trap.h) go on: lighting rays, or rendering rays into `framebuffer`. What their answers
// alone did, and as emitted what they bring, is added to `counters`; the rest is the machine's. Throws Stall, RoutineFault.
RunResult resume(std::span<const wire::Ray> answers, const Frame& frame, Framebuffer& framebuffer,
                 const v1::DspConfig& dsp, Machine& machine, RayCounters& counters, Progress& work);

// Rays that are there already, and what they cost the DSP.
struct GivenRayBatch {
  std::span<wire::Ray> rays;  // one with no flags is not sent
  bool come_back = true;      // into their places; else nothing of them is kept
  std::uint32_t make_cycles = 0;
  std::uint32_t take_cycles = 0;
};

// Takes them to their ends. A ray that lies behind a cut plane stays as it is.
RunResult trace(const GivenRayBatch& rays, const Frame& frame, Machine& machine, Progress& work);

}  // namespace gicube::emu
