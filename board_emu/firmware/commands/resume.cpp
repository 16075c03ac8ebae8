// Rays that only the host can scatter: they are sent to it, returned, and continued.

#include "command_fault.h"
#include "commands.h"
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

wire::LightingLedger ledger_of(std::size_t word, const RayCounters& counts, bool light_in_solid) {
  const EnergyCounters& energy = counts.energy_of(word);
  wire::LightingLedger ledger;
  ledger.rays = counts.lighting_rays;
  ledger.emitted = energy.emitted;
  ledger.deposited = energy.deposited.kept;
  ledger.escaped = energy.escaped;
  ledger.escaped_by_face = energy.escaped_by_face;
  ledger.scattered_away = energy.scattered_away;
  ledger.given_up = energy.given_up;
  ledger.clipped = energy.deposited.clipped;
  ledger.light_in_solid = light_in_solid ? 1 : 0;
  return ledger;
}

}  // namespace

// Adds one ledger for each irradiance word.
void DspCommands::add_ledger(CommandResult& result, const RayCounters& counts, bool light_in_solid) const {
  for (std::size_t word = 0; word < config_.asic().irradiance_words(); ++word) {
    const std::vector<std::uint8_t> bytes = wire::encoded(ledger_of(word, counts, light_in_solid));
    result.payload.insert(result.payload.end(), bytes.begin(),
                          bytes.begin() + static_cast<std::ptrdiff_t>(wire::lighting_ledger_bytes(minor_version_)));
  }
  result.up_bytes = result.payload.size();
}

// Sends at most `max_rays` of the waiting rays to the host. If none waits, no list is appended.
void DspCommands::add_trap_list(CommandResult& result, std::size_t max_rays) {
  host_traps_.settle();
  if (host_traps_.waiting() == 0) return;
  const std::vector<wire::TrappedRay> rays = host_traps_.take(max_rays);
  wire::append(result.payload, wire::TrapListHeader{static_cast<std::uint32_t>(rays.size()),
                                                    static_cast<std::uint32_t>(host_traps_.waiting())});
  for (const wire::TrappedRay& ray : rays) wire::append(result.payload, ray);
  result.up_bytes = result.payload.size();
  result.returns_rays = !rays.empty();
  const std::uint64_t cycles = config_.ideal().dsp() != 0 ? 0 : rays.size() * kPassRay.interval();
  result.dsp_cycles += cycles;
  if (result.asic_ps != 0) result.asic_ps += cycles_to_ps(cycles, config_.dsp().clock_khz());
  host_traps_total_ += rays.size();
}

CommandResult DspCommands::resume(std::span<const std::uint8_t> payload, Progress& work) {
  expect(payload.size() >= wire::kResumeHeaderBytes, "payload", "at least 16 bytes", payload.size());
  const auto [count, max_rays] = wire::decode<wire::ResumeHeader>(payload);
  if (payload.size() != wire::kResumeHeaderBytes + std::uint64_t{count} * wire::kRayBytes) {
    refuse("payload", "16 + 32 bytes for each of its " + std::to_string(count) + " rays", payload.size());
  }
  expect(max_rays <= kMaxInList, "most", "0..65536", max_rays);
  if (!goes_on_ && count > host_traps_.out()) {
    refuse("count", "at most the rays handed out and not answered, " + std::to_string(host_traps_.out()), count);
  }
  check_volume();
  check_all_there();
  check_materials();
  Frame frame = this->frame();
  const bool light = host_traps_.is_light();
  if (light) set_light(frame, host_traps_.rules());
  frame.lamps = !light && !lamps_.empty();
  std::vector<wire::Ray> answers(count);
  for (std::size_t i = 0; i < count; ++i) {
    answers[i] = wire::decode<wire::Ray>(payload.subspan(wire::kResumeHeaderBytes + i * wire::kRayBytes));
    check_part("ray", i, [&] { check_answer(answers[i], frame.extent, light); });
  }
  expect_memory(frame);
  aperture_.decode(threads_, reads(frame));
  if (!goes_on_) host_traps_.answered(count);
  RunResult ran;
  if (count > 0) {
    ResumedRays rays(answers, frame, aperture_.framebuffer(), lamps_);
    ran = run_level(rays, frame, work);
  }
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  result.takes_rays = count > 0;
  if (light) {
    add_ledger(result, ran.rays, false);
  } else {
    aperture_.resolve_framebuffer(threads_);
  }
  add_trap_list(result, max_rays);
  return result;
}

}  // namespace gicube::emu
