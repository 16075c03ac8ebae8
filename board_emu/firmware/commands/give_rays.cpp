// Adds rays to the card that were on another one (wire/forwarded_ray.h).
#include <bit>

#include "command_fault.h"
#include "each_command.h"
#include "firmware/ray_sources/host_rays.h"

namespace gicube::emu {

namespace {

WaitingRay of_record(const wire::ForwardedRay& ray) {
  WaitingRay out{.number = ray.number, .block = ray.block, .home = ray.home, .trapped = ray.trapped != 0};
  RayState& state = out.ray_state;
  state.position = ray.position;
  state.step = ray.step;
  state.exponent = ray.exponent;
  state.length = ray.length;
  state.opacity = ray.opacity;
  state.interacted = ray.interacted;
  state.colour = ray.colour;
  state.direction = ray.direction;
  state.u = ray.u, state.v = ray.v;
  state.lifetime = ray.lifetime;
  state.generation = ray.generation & 15;
  state.under_way = ray.under_way & 1;
  state.flags = ray.flags;
  state.wide.opacity = std::bit_cast<float>(ray.wide[0]);
  for (std::size_t c = 0; c < kColours; ++c) state.wide.colour[c] = std::bit_cast<float>(ray.wide[1 + c]);
  state.rest = ray.rest;
  state.step_rest = ray.step_rest;
  state.more_energy = {ray.green_energy, ray.blue_energy};
  return out;
}

// True for a number from 0 to `most`; false for NaN.
bool is_within(std::uint32_t bits, float most) {
  const float value = std::bit_cast<float>(bits);
  return value >= 0 && value <= most;
}

void check_forwarded(const wire::ForwardedRay& ray, const Frame& frame) {
  if (!inside(ray.position, frame.extent)) refuse("position: expected a point of the volume");
  expect(ray.block < frame.empty.size(), "block", "one of the volume", ray.block);
  if (frame.segments()) {  // steps are counted, so any step vector is valid
    constexpr std::uint32_t kMost = wire::steps_of(wire::kMaxLength, wire::kStepMin);
    expect(ray.interacted <= kMost, "interacted", "at most 262144 steps of a segment", ray.interacted);
  } else if (ray.step == Point{}) {
    refuse("step: expected a vector other than 0, got 0");
  }
  expect(ray.opacity <= wire::kOpacityOne, "opacity", "at most 2^24 - 1", ray.opacity);
  expect(ray.generation <= 15, "generation", "0..15", ray.generation);
  expect(ray.under_way <= 1, "under_way", "0 or 1", ray.under_way);
  expect(ray.trapped <= 1, "trapped", "0 or 1", ray.trapped);
  for (const std::uint16_t colour : ray.colour) expect(colour <= wire::kColourOne, "colour", "at most 4095", colour);
  if (!is_within(ray.wide[0], 1)) refuse("wide: expected an opacity of 0..1");
  for (const std::uint32_t bits : std::span(ray.wide).subspan(1)) {
    if (!is_within(bits, wire::kColourOne)) refuse("wide: expected colours of 0..4095");
  }
}

// The rays belong to the commands whose rays wait here, or start a new series.
void begin_given(Card& card, const wire::GiveRaysHeader& header) {
  if (header.of == wire::RaysOf::kPicture) {
    const bool begun = card.waiting_rays.kind() == WaitingKind::kPicture && card.aperture.framebuffer().width() > 0;
    if (!begun) refuse("of: expected 1 or 2, since no picture was begun, got 0");
    return;
  }
  wire::TraceHeader trace = header.trace;
  trace.count = 0;
  const WaitingKind kind = header.of == wire::RaysOf::kTrace ? WaitingKind::kHostRays : WaitingKind::kLight;
  if (kind == WaitingKind::kLight) trace = {.type = wire::RayType::kDeposit, .rules = trace.rules};
  if (card.waiting_rays.kind() == kind && card.waiting_rays.header() == trace) return;
  if (card.waiting_rays.count() > 0) refuse("of, trace: expected those of the rays that wait, got others");
  card.drop_rays();
  card.waiting_rays.begin(kind, trace);
}

}  // namespace

CommandResult give_rays(Card& card, Payload payload, Progress& /*work*/) {
  const auto header = header_of<wire::GiveRaysHeader>(payload);
  const std::uint64_t bytes = std::uint64_t{header.rays} * wire::kForwardedRayBytes;
  if (payload.size() != wire::kGiveRaysHeaderBytes + bytes + std::uint64_t{header.ended} * wire::kEndedRayBytes) {
    refuse("payload", "32 bytes, 128 for each of its rays and 64 for each that has ended", payload.size());
  }
  expect(header.of <= wire::RaysOf::kLight, "of", "0..2", static_cast<std::uint64_t>(header.of));
  card.check_volume();
  if (!card.in_bricks()) refuse("BRICKS: expected 1, or a volume with more blocks than the card stores");
  if (header.of != wire::RaysOf::kPicture) {
    check_trace_header(header.trace);
    expect(header.trace.type != wire::RayType::kBackproject, "type", "0..5",
           static_cast<std::uint64_t>(header.trace.type));
  }
  begin_given(card, header);
  const Frame frame = card.continued_frame();
  const bool picture = header.of == wire::RaysOf::kPicture;
  const std::span<wire::Ray> host_rays(card.aperture.host_rays());
  std::vector<WaitingRay> rays;
  rays.reserve(header.rays);
  for (std::size_t i = 0; i < header.rays; ++i) {
    const auto record =
        wire::decode<wire::ForwardedRay>(payload.subspan(wire::kGiveRaysHeaderBytes + i * wire::kForwardedRayBytes));
    check_part("ray", i, [&] {
      check_forwarded(record, frame);
      expect(((record.flags & wire::kLightingRay) != 0) == frame.lights(), "flags",
             frame.lights() ? "those of a lighting ray" : "those of a rendering ray", record.flags);
      const bool has_place = record.home != 0 || header.of != wire::RaysOf::kTrace || frame.lights();
      expect(has_place || record.number < host_rays.size(), "number", "one of the host rays in the DSP's memory",
             record.number);
    });
    rays.push_back(of_record(record));
  }
  std::vector<wire::EndedRay> ended;
  for (std::size_t i = 0; i < header.ended; ++i) {
    const std::size_t at = wire::kGiveRaysHeaderBytes + static_cast<std::size_t>(bytes) + i * wire::kEndedRayBytes;
    ended.push_back(wire::decode<wire::EndedRay>(payload.subspan(at)));
    check_part("ended ray", i, [&] {
      expect(ended.back().home == 0, "home", "0", ended.back().home);
      expect(picture || ended.back().number < host_rays.size(), "number", "one of the host rays in the DSP's memory",
             ended.back().number);
    });
  }
  card.aperture.host_deposits().begin();
  card.waiting_rays.give(rays);
  card.arrived_rays += rays.size() + ended.size();
  for (const wire::EndedRay& each : ended) {
    if (picture) {
      card.aperture.framebuffer().add(card.lamps.seen_by(each.ray));
    } else {
      put_back(each.ray, host_rays[static_cast<std::size_t>(each.number)]);
    }
  }
  if (picture && card.waiting_rays.count() == 0) card.aperture.resolve_framebuffer(card.threads);
  const std::size_t packets = (payload.size() - wire::kGiveRaysHeaderBytes) / wire::kRayBytes;
  const std::size_t cycles = packets * kPassRay.interval() + (picture ? ended.size() * kAddToPixel.interval() : 0);
  CommandResult result{.dsp_cycles = card.dsp_cycles(cycles)};
  card.add_waiting(result);
  return result;
}

}  // namespace gicube::emu
