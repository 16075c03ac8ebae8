// Rays that have waited for blocks continue when the host has written them.
#include "command_fault.h"
#include "each_command.h"
#include "firmware/ray_sources/continued_rays.h"

namespace gicube::emu {

CommandResult ContinueRays::run(Payload payload, Progress& work) {
  expect(payload.size() == wire::kContinueCommandBytes, "payload", "8 bytes", payload.size());
  card_.check_volume();
  if (!card_.goes_on && card_.waiting_rays.count() == 0) refuse("no ray waits for a block");
  Frame frame = card_.continued_frame();
  const std::uint32_t traps = card_.waiting_rays.trapped_tags();
  if (frame.scatter || frame.lights() || traps != 0) card_.check_materials(false);
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    if ((traps >> tag & 1) == 0) continue;
    check_part("material", tag, [&] {
      const auto bsdf = static_cast<std::uint64_t>(frame.materials[tag].bsdf);
      expect(frame.materials[tag].bsdf == wire::Bsdf::kTrap, "bsdf", "6, since rays wait that it has trapped", bsdf);
    });
  }
  card_.set_bricks(frame);
  card_.expect_memory(frame);
  card_.aperture.decode(card_.threads, reads(frame));
  const auto ready = card_.goes_on ? card_.waiting_rays.continued() : card_.waiting_rays.take_ready(frame);
  const bool picture = card_.waiting_rays.kind() == WaitingKind::kPicture;
  ContinuedRays::Ends ends;
  if (picture) {
    ends = {.framebuffer = &card_.aperture.framebuffer(), .lamps = &card_.lamps};
  } else {
    ends.host_rays = card_.aperture.host_rays();
  }
  if (!frame.lights()) ends.others = &card_.waiting_rays;
  ContinuedRays rays(ready, frame, ends);
  const RunResult ran = card_.run_level(rays, frame, work);
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  if (frame.lights()) card_.add_ledger(result, ran.rays, false);
  if (picture && card_.waiting_rays.count() == 0) card_.aperture.resolve_framebuffer(card_.threads);
  card_.add_waiting(result);
  return result;
}
}  // namespace gicube::emu
