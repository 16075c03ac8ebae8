// Rays that have waited for blocks continue when the host has written them.
#include "command_fault.h"
#include "each_command.h"
#include "firmware/ray_sources/continued_rays.h"

namespace gicube::emu {

CommandResult continue_rays(Card& card, Payload payload, Progress& work) {
  expect(payload.size() == wire::kContinueCommandBytes, "payload", "8 bytes", payload.size());
  card.check_volume();
  if (!card.goes_on && card.waiting_rays.count() == 0) refuse("no ray waits for a block");
  Frame frame = card.continued_frame();
  const std::uint32_t traps = card.waiting_rays.trapped_tags();
  if (frame.scatter || frame.lights() || traps != 0) card.check_materials(false);
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    if ((traps >> tag & 1) == 0) continue;
    check_part("material", tag, [&] {
      const auto bsdf = static_cast<std::uint64_t>(frame.materials[tag].bsdf);
      expect(frame.materials[tag].bsdf == wire::Bsdf::kTrap, "bsdf", "6, since rays wait that it has trapped", bsdf);
    });
  }
  card.set_bricks(frame);
  card.expect_memory(frame);
  card.aperture.decode(card.threads, reads(frame));
  const auto ready = card.goes_on ? card.waiting_rays.continued() : card.waiting_rays.take_ready(frame);
  const bool picture = card.waiting_rays.kind() == WaitingKind::kPicture;
  ContinuedRays::Ends ends;
  if (picture) {
    ends = {.framebuffer = &card.aperture.framebuffer(), .lamps = &card.lamps};
  } else {
    ends.host_rays = card.aperture.host_rays();
  }
  if (!frame.lights()) ends.others = &card.waiting_rays;
  ContinuedRays rays(ready, frame, ends);
  const RunResult ran = card.run_level(rays, frame, work);
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  if (frame.lights()) card.add_ledger(result, ran.rays, false);
  if (picture && card.waiting_rays.count() == 0) card.aperture.resolve_framebuffer(card.threads);
  card.add_waiting(result);
  return result;
}
}  // namespace gicube::emu
