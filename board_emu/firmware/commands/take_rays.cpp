// Takes rays from the card that continue on another one (wire/forwarded_ray.h).
#include <bit>

#include "command_fault.h"
#include "each_command.h"

namespace gicube::emu {

namespace {

wire::ForwardedRay to_record(const WaitingRay& ray) {
  const RayState& state = ray.ray_state;
  wire::ForwardedRay out{.number = ray.number,
                         .block = ray.block,
                         .home = ray.home,
                         .trapped = ray.trapped,
                         .position = state.position,
                         .step = state.step,
                         .exponent = state.exponent,
                         .length = state.length,
                         .opacity = state.opacity,
                         .interacted = state.interacted,
                         .colour = state.colour,
                         .direction = state.direction,
                         .u = state.u,
                         .v = state.v,
                         .lifetime = state.lifetime,
                         .generation = state.generation,
                         .under_way = state.under_way,
                         .flags = state.flags,
                         .rest = state.rest,
                         .step_rest = state.step_rest,
                         .green_energy = state.more_energy[0],
                         .blue_energy = state.more_energy[1]};
  out.wide[0] = std::bit_cast<std::uint32_t>(state.wide.opacity);
  for (std::size_t c = 0; c < kColours; ++c) out.wide[1 + c] = std::bit_cast<std::uint32_t>(state.wide.colour[c]);
  return out;
}

}  // namespace

CommandResult take_rays(Card& card, Payload payload, Progress& /*work*/) {
  const auto header = header_of<wire::TakeRaysHeader>(payload);
  if (payload.size() != wire::kTakeRaysHeaderBytes + std::uint64_t{header.blocks} * 4) {
    refuse("payload", "16 bytes and 4 for each of its " + std::to_string(header.blocks) + " blocks", payload.size());
  }
  expect(header.ended <= 1, "ended", "0 or 1", header.ended);
  expect(header.ended == 0 || header.blocks == 0, "blocks", "0 where rays that have ended are taken", header.blocks);
  expect(header.max_rays >= 1 && header.max_rays <= 65536, "max_rays", "1..65536", header.max_rays);
  std::vector<std::uint32_t> blocks(header.blocks);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    blocks[i] = wire::load<std::uint32_t>(payload, wire::kTakeRaysHeaderBytes + 4 * i);
    if (i > 0 && blocks[i] <= blocks[i - 1]) refuse("blocks: expected ascending numbers");
  }
  CommandResult result;
  std::size_t taken = 0, left = 0;
  std::vector<std::uint8_t> records;
  if (header.ended != 0) {
    const auto rays = card.waiting_rays.take_ended(header.max_rays);
    for (const wire::EndedRay& ray : rays) wire::append(records, ray);
    taken = rays.size(), left = card.waiting_rays.ended();
  } else {
    const auto rays = card.waiting_rays.take(blocks, header.max_rays);
    for (const WaitingRay& ray : rays) wire::append(records, to_record(ray));
    taken = rays.size(), left = card.waiting_rays.count(blocks);
  }
  result.payload =
      wire::encoded(wire::TakenHeader{static_cast<std::uint32_t>(taken), static_cast<std::uint32_t>(left)});
  result.payload.insert(result.payload.end(), records.begin(), records.end());
  result.up_bytes = result.payload.size();
  card.forwarded_rays += taken;
  const bool last = taken > 0 && card.waiting_rays.count() == 0;
  if (last && card.waiting_rays.kind() == WaitingKind::kPicture) card.aperture.resolve_framebuffer(card.threads);
  result.dsp_cycles = card.dsp_cycles(records.size() / wire::kRayBytes * kPassRay.interval());
  return result;
}

}  // namespace gicube::emu
