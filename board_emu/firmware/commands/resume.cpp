// Rays that only the host can scatter: they are sent to it, returned, and continued.

#include "command_fault.h"
#include "each_command.h"
#include "firmware/ray_sources/resumed_rays.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

namespace {

constexpr std::uint32_t kMaxInList = 1u << 16;  // chosen: 4 MiB, the largest payload

void check_answer(const wire::Ray& ray, const Point& extent, bool light) {
  check_ray(ray, extent);
  expect(ray.lifetime >= 1, "lifetime", "at least 1", 0);
  if (((ray.flags & wire::kLightingRay) != 0) != light) {
    refuse(std::string("flags: expected a ") + (light ? "lighting" : "rendering") + " ray");
  }
}

}  // namespace

CommandResult resume_rays(Card& card, Payload payload, Progress& work) {
  const auto [count, max_rays] = header_of<wire::ResumeHeader>(payload);
  if (payload.size() != wire::kResumeHeaderBytes + std::uint64_t{count} * wire::kRayBytes) {
    refuse("payload", "16 + 32 bytes for each of its " + std::to_string(count) + " rays", payload.size());
  }
  expect(max_rays <= kMaxInList, "max_rays", "0..65536", max_rays);
  if (!card.goes_on && count > card.host_traps.out()) {
    refuse("count",
           "at most the number of rays that were handed out and not answered, " + std::to_string(card.host_traps.out()),
           count);
  }
  card.check_volume();
  card.check_all_there();
  card.check_materials();
  Frame frame = card.frame();
  const bool light = card.host_traps.is_light();
  if (light) card.set_light(frame, card.host_traps.rules());
  frame.lamps = !light && !card.lamps.empty();
  std::vector<wire::Ray> answers(count);
  for (std::size_t i = 0; i < count; ++i) {
    answers[i] = wire::decode<wire::Ray>(payload.subspan(wire::kResumeHeaderBytes + i * wire::kRayBytes));
    check_part("ray", i, [&] { check_answer(answers[i], frame.extent, light); });
  }
  card.expect_memory(frame);
  card.aperture.decode(card.threads, reads(frame));
  if (!card.goes_on) card.host_traps.answered(count);
  RunResult ran;
  if (count > 0) {
    ResumedRays rays(answers, frame, card.aperture.framebuffer(), card.lamps);
    ran = card.run_level(rays, frame, work);
  }
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  result.takes_rays = count > 0;
  if (light) {
    card.add_ledger(result, ran.rays, false);
  } else {
    card.aperture.resolve_framebuffer(card.threads);
  }
  card.add_trap_list(result, max_rays);
  return result;
}

}  // namespace gicube::emu
