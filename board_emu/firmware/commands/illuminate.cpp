// The illuminate command: deposits the energy of one light's rays in the volume.
#include "command_fault.h"
#include "datapath/interaction.h"
#include "each_command.h"
#include "firmware/lighting_rays.h"
#include "firmware/ray_sources/light_rays.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

namespace {

// True if the volume is opaque at the light's position. All its energy then stays there.
bool light_in_solid(const wire::IlluminateCommand& command, const Frame& frame) {
  if (command.kind == wire::LightKind::kDirectional) return false;
  Point at{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double voxels = command.position[axis];
    if (command.kind == wire::LightKind::kRectangle) {
      voxels += (command.u[axis] + command.v[axis]) / 2 * wire::kSpacingOne / frame.spacing[axis];
    }
    if (!(voxels >= 0) || voxels * wire::kVoxel > frame.extent[axis]) return false;
    at[axis] = static_cast<std::int32_t>(voxels * wire::kVoxel);
  }
  return sample_at(at, frame).entry.opacity >= wire::kClassifiedOpacityOne / 2;
}

}  // namespace

CommandResult illuminate_volume(Card& card, Payload payload, Progress& work) {
  expect(payload.size() == wire::kIlluminateCommandBytes, "payload", "104 bytes", payload.size());
  const auto command = wire::decode<wire::IlluminateCommand>(payload);
  card.check_volume();
  const bool waits = card.in_bricks();
  if (!waits) card.check_all_there();
  Frame frame = card.frame();
  card.check_materials(!waits && frame.light_words == 1);
  if (const auto what = LightingRays::fault(command, frame.extent)) refuse(*what);
  card.set_light(frame, command.rules);
  for (std::uint32_t word = 0; frame.light_words > 1 && word < kColours; ++word) {
    frame.light_colour[word] = static_cast<std::uint16_t>(card.registers.value(wire::reg::kLightRed + 4 * word));
  }
  if (waits && !card.goes_on) {
    card.drop_rays();
    card.waiting_rays.begin(WaitingKind::kLight, {.type = wire::RayType::kDeposit, .rules = command.rules});
  }
  if (waits) card.set_bricks(frame);
  card.expect_memory(frame);
  if (!card.goes_on) card.host_traps.begin(true, command.rules);
  const unsigned bits = frame.wide ? 24 : command.albedo == wire::Albedo::kHigh ? 4 : 8;  // [P §4.2]
  card.aperture.decode(card.threads, reads(frame));
  const LightingRays maker(command, frame.extent, frame.spacing, bits, frame.seed);
  LightRays rays(maker, frame);
  const RunResult ran = card.run_level(rays, frame, work);
  card.lighting_rays += ran.made;
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  card.add_ledger(result, ran.rays, light_in_solid(command, frame));
  card.add_waiting(result);
  card.add_trap_list(result, 0);
  return result;
}

}  // namespace gicube::emu
