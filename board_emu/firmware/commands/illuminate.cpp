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
  return opacity_at(at, frame) >= wire::kClassifiedOpacityOne / 2;
}

}  // namespace

CommandResult IlluminateVolume::run(Payload payload, Progress& work) {
  expect(payload.size() == wire::kIlluminateCommandBytes, "payload", "104 bytes", payload.size());
  const auto command = wire::decode<wire::IlluminateCommand>(payload);
  card_.check_volume();
  const bool waits = card_.in_bricks();
  if (!waits) card_.check_all_there();
  Frame frame = card_.frame();
  card_.check_materials(!waits && frame.light_words == 1);
  if (const auto what = LightingRays::fault(command, frame.extent)) refuse(*what);
  card_.set_light(frame, command.rules);
  for (std::uint32_t word = 0; frame.light_words > 1 && word < kColours; ++word) {
    frame.light_colour[word] = static_cast<std::uint16_t>(card_.registers.value(wire::reg::kLightRed + 4 * word));
  }
  if (waits && !card_.goes_on) {
    card_.drop_rays();
    card_.waiting_rays.begin(WaitingKind::kLight, {.type = wire::RayType::kDeposit, .rules = command.rules});
  }
  if (waits) card_.set_bricks(frame);
  card_.expect_memory(frame);
  if (!card_.goes_on) card_.host_traps.begin(true, command.rules);
  const unsigned bits = frame.wide ? 24 : command.albedo == wire::Albedo::kHigh ? 4 : 8;  // [P §4.2]
  card_.aperture.decode(card_.threads, reads(frame));
  const LightingRays maker(command, frame.extent, frame.spacing, bits, frame.seed);
  LightRays rays(maker, frame);
  const RunResult ran = card_.run_level(rays, frame, work);
  card_.lighting_rays += ran.made;
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  card_.add_ledger(result, ran.rays, light_in_solid(command, frame));
  card_.add_waiting(result);
  card_.add_trap_list(result, 0);
  return result;
}

}  // namespace gicube::emu
