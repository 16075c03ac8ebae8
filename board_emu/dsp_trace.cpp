// Rays that the host made [P §3.5, §3.6]: what it asks of them, and how they go back to it.
#include <algorithm>

#include "command_fault.h"
#include "cycle_level.h"
#include "dsp_commands.h"
#include "functional_level.h"
#include "gicube/wire/command.h"
#include "machine_counters.h"
#include "meet.h"

namespace gicube::emu {

namespace {

using wire::RayType;

bool has_threshold(RayType type) {
  return type == RayType::kFirstHit || type == RayType::kSegment || type == RayType::kOpacity;
}

bool is_segment(RayType type) { return type == RayType::kSegment || type == RayType::kOpacity; }

std::optional<std::string> fault(const wire::TraceHeader& header, std::size_t payload_bytes) {
  const std::uint64_t bytes = wire::kTraceHeaderBytes + std::uint64_t{header.count} * wire::kRayBytes;
  if (payload_bytes != bytes) {
    return expected("payload", "16 + 32 bytes for each of its " + std::to_string(header.count) + " rays",
                    payload_bytes);
  }
  if (header.type > RayType::kDeposit) return expected("type", "0..4", static_cast<std::uint64_t>(header.type));
  const bool deposit = header.type == RayType::kDeposit;
  if (static_cast<unsigned>(header.albedo) > (deposit ? 1u : 0u)) {
    return expected("albedo", deposit ? "0 or 1" : "0", static_cast<std::uint64_t>(header.albedo));
  }
  if (static_cast<unsigned>(header.rules) > (deposit ? 1u : 0u)) {
    return expected("rules", deposit ? "0 or 1" : "0", static_cast<std::uint64_t>(header.rules));
  }
  if (!has_threshold(header.type) && header.opacity != 0) return expected("opacity", "0", header.opacity);
  if (has_threshold(header.type) && (header.opacity < 1 || header.opacity > wire::kOpacityOne)) {
    return expected("opacity", "1..2^24 - 1", header.opacity);
  }
  return std::nullopt;
}

std::uint8_t flags_of(const wire::TraceHeader& header) {
  if (header.type != RayType::kDeposit) return wire::kHostRay;
  return static_cast<std::uint8_t>(wire::kHostRay | wire::kLightingRay |
                                   (header.albedo == wire::Albedo::kHigh ? wire::kHighAlbedo : 0));
}

// As many bits as a ray's energy has [P §4.2].
std::uint64_t most_energy(const wire::TraceHeader& header, bool wide) {
  const unsigned bits = wide ? 24 : header.albedo == wire::Albedo::kHigh ? 4 : 8;
  return ((std::uint64_t{1} << bits) - 1) << kEnergyFractionBits;
}

std::optional<std::string> fault_of_colour(const wire::Ray& ray, RayType type, std::uint64_t most) {
  const std::uint64_t word = ray.colour_word();
  if (is_segment(type) && word > wire::kMostLength) return expected("length", "0..4096 voxels in 16.16", word);
  if (is_segment(type) && ray.opacity != 0) return expected("opacity", "0 of a segment", ray.opacity);
  if (type == RayType::kDeposit && (word == 0 || word > most)) {
    return expected("energy", "1.." + std::to_string(most) + " (24.12)", word);
  }
  return std::nullopt;
}

// What of the frame is otherwise for rays of this type.
void set_type(Frame& frame, const wire::TraceHeader& header) {
  if (header.type == RayType::kDeposit) {
    frame.plain = false;
    frame.opacity_threshold = wire::kOpacityOne;  // it ends rays that gather
    frame.rules = header.rules;
    frame.cut_planes.clear();  // they cut what the eye sees
    return;
  }
  if (!has_threshold(header.type)) return;
  frame.opacity_threshold = header.opacity;
  frame.to_the_hit = true;
  frame.scatter = frame.high_albedo = false;
  frame.colourless = header.type != RayType::kSegment;
  if (frame.colourless) frame.lit_by_irradiance = false;
  frame.plain = !frame.lit_by_irradiance;
  if (!is_segment(header.type)) return;
  frame.segments = true;
  frame.jitter = false;
  frame.cut_planes.clear();
}

}  // namespace

void set_opacity_rays(Frame& frame, std::uint32_t opacity) {
  set_type(frame, {.type = RayType::kOpacity, .opacity = opacity});
}

CommandResult DspCommands::trace(std::span<const std::uint8_t> payload, Work& work) {
  if (payload.size() < wire::kTraceHeaderBytes) return refuse(expected("payload", "at least 16 bytes", payload.size()));
  const auto header = wire::decode_trace(payload.first<wire::kTraceHeaderBytes>());
  if (const auto what = fault(header, payload.size())) return refuse(*what);
  if (!has_volume()) return refuse(kNoVolume);
  const bool deposit = header.type == RayType::kDeposit;
  Frame frame = this->frame();
  set_type(frame, header);
  if (frame.scatter || deposit) {
    if (const auto what = material_fault(false)) return refuse(*what);
  }
  const std::size_t count = header.count;
  const std::uint64_t most = most_energy(header, frame.wide);
  std::vector<wire::Ray>& rays = host_ray_room_;
  rays.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    rays[i] = wire::decode_ray(payload.subspan(wire::kTraceHeaderBytes + i * wire::kRayBytes).first<wire::kRayBytes>());
    const auto which = [i] { return "ray " + std::to_string(i) + ": "; };
    if (rays[i].flags != flags_of(header)) {
      return refuse(which() + expected("flags", std::to_string(flags_of(header)), rays[i].flags));
    }
    if (const auto what = fault(rays[i], frame.extent)) return refuse(which() + *what);
    if (const auto what = fault_of_colour(rays[i], header.type, most)) return refuse(which() + *what);
  }
  aperture_.decode(threads_);
  CommandResult result;
  RayCounters counts;
  if (config_.fidelity() == v1::cycle) {
    const RayCounters before = ray_counters(machine());
    for (const wire::Ray& ray : rays) {  // the machine counts what becomes of it
      if (deposit) counts.energy.emitted += energy_units(set_out(ray, frame), frame);
    }
    const std::uint32_t both = config_.dsp().host_ray_cycles(), first = both / 2;  // for both ways
    const GivenRays given{rays, !deposit, first, deposit ? 0 : both - first};
    const Ran ran = emu::trace(given, frame, machine(), work);
    if (ran.cancelled) return cancelled();
    counts += ray_counters(machine()) - before;
    result = timed(ran);
  } else {
    const bool fast = opacity_march_.prepare(count, frame, aperture_.segmentation_writes(), threads_);
    counts = emu::trace(rays, frame, fast ? &opacity_march_ : nullptr, threads_);
    rays_ += counts;
    const std::uint64_t cycles = config_.dsp().host_ray_cycles();  // for both ways
    result.dsp_cycles = count * (deposit ? cycles / 2 : cycles) + counts.trap_cycles;
  }
  host_rays_ += count;
  result.takes_rays = count > 0;
  if (deposit) {
    lighting_rays_ += count;
    add_ledger(result, counts, false);
    return result;
  }
  result.payload.resize(count * wire::kRayBytes);
  for (std::size_t i = 0; i < count; ++i) {
    wire::encode(rays[i], std::span(result.payload).subspan(i * wire::kRayBytes).first<wire::kRayBytes>());
  }
  result.up_bytes = std::max<std::uint64_t>(result.payload.size(), 4);
  result.returns_rays = count > 0;
  result.leaves_nothing = true;
  return result;
}

}  // namespace gicube::emu
