// Rays that only the host can scatter: they go to it, come back, and go on.
#include <algorithm>

#include "command_fault.h"
#include "commands.h"
#include "firmware/ray_sources/resumed_rays.h"
#include "gicube/wire/trap.h"

namespace gicube::emu {

namespace {

constexpr std::uint32_t kMaxInList = 1u << 16;  // chosen: 4 MiB, the largest payload

std::optional<std::string> fault_of_answer(const wire::Ray& ray, const Point& extent, bool light) {
  if (const auto what = fault(ray, extent)) return what;
  if (ray.lifetime == 0) return "lifetime: expected at least 1, got 0";
  if (((ray.flags & wire::kLightingRay) != 0) != light) {
    return std::string("flags: expected a ") + (light ? "lighting" : "rendering") + " ray";
  }
  return std::nullopt;
}

}  // namespace

void DspCommands::add_ledger(CommandResult& result, const RayCounters& counts, bool light_in_solid) {
  const EnergyCounters& energy = counts.energy;
  wire::LightingLedger ledger;
  ledger.rays = counts.lighting_rays;
  ledger.emitted = energy.emitted;
  ledger.deposited = energy.deposited.kept;
  ledger.escaped = energy.escaped;
  ledger.scattered_away = energy.scattered_away;
  ledger.given_up = energy.given_up;
  ledger.clipped = energy.deposited.clipped;
  ledger.light_in_solid = light_in_solid ? 1 : 0;
  result.payload = wire::encoded(ledger);
  result.up_bytes = result.payload.size();
}

// Hands at most `most` of the waiting rays out. Without any that wait there is no list.
void DspCommands::add_trap_list(CommandResult& result, std::size_t most) {
  host_traps_.settle();
  if (host_traps_.waiting() == 0) return;
  const std::vector<wire::TrappedRay> rays = host_traps_.take(most);
  wire::append(result.payload, wire::TrapListHeader{static_cast<std::uint32_t>(rays.size()),
                                                    static_cast<std::uint32_t>(host_traps_.waiting())});
  for (const wire::TrappedRay& ray : rays) wire::append(result.payload, ray);
  result.up_bytes = result.payload.size();
  result.returns_rays = !rays.empty();
  // host_ray_cycles is for both ways; the other half is taken with the answer.
  const std::uint64_t cycles = rays.size() * (config_.dsp().host_ray_cycles() - config_.dsp().host_ray_cycles() / 2);
  result.dsp_cycles += cycles;
  if (result.asic_ps != 0) result.asic_ps += cycles_to_ps(cycles, config_.dsp().clock_khz());
  host_traps_total_ += rays.size();
}

CommandResult DspCommands::resume(std::span<const std::uint8_t> payload, Progress& work) {
  if (payload.size() < wire::kResumeHeaderBytes)
    return refuse(expected("payload", "at least 16 bytes", payload.size()));
  const auto [count, most] = wire::decode<wire::ResumeHeader>(payload);
  if (payload.size() != wire::kResumeHeaderBytes + std::uint64_t{count} * wire::kRayBytes) {
    return refuse(
        expected("payload", "16 + 32 bytes for each of its " + std::to_string(count) + " rays", payload.size()));
  }
  if (most > kMaxInList) return refuse(expected("most", "0..65536", most));
  if (count > host_traps_.out()) {
    return refuse(
        expected("count", "at most the rays handed out and not answered, " + std::to_string(host_traps_.out()), count));
  }
  if (!has_volume()) return refuse(kNoVolume);
  if (const auto what = material_fault()) return refuse(*what);
  Frame frame = this->frame();
  const bool light = host_traps_.is_light();
  if (light) {
    aperture_.irradiance().expect_deposits();
    frame.type = wire::RayType::kDeposit;
    frame.opacity_threshold = wire::kOpacityOne;
    frame.rules = host_traps_.rules();
  }

  std::vector<wire::Ray> answers(count);
  for (std::size_t i = 0; i < count; ++i) {
    answers[i] = wire::decode<wire::Ray>(payload.subspan(wire::kResumeHeaderBytes + i * wire::kRayBytes));
    if (const auto what = fault_of_answer(answers[i], frame.extent, light)) {
      return refuse("ray " + std::to_string(i) + ": " + *what);
    }
  }
  aperture_.decode(threads_, reads(frame));
  host_traps_.answered(count);
  RunResult ran;
  if (count > 0) {
    ResumedRays rays(answers, frame, aperture_.framebuffer(), config_.dsp());
    ran = run_level(rays, frame, work);
    if (ran.cancelled) return {.error = wire::ErrorCode::kCancelled};
  }
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  result.takes_rays = count > 0;
  if (light) {
    add_ledger(result, ran.rays, false);
  } else {
    aperture_.resolve_framebuffer(threads_);
  }
  add_trap_list(result, most);
  return result;
}

}  // namespace gicube::emu
