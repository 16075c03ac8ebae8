// The illuminate command: deposits the energy of one light's rays in the volume.
#include "command_fault.h"
#include "commands.h"
#include "datapath/interaction.h"
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

// Configures the frame of a command whose rays deposit energy.
void DspCommands::set_light(Frame& frame, wire::EnergyRules rules) {
  aperture_.expect_deposits();
  frame.type = wire::RayType::kDeposit;
  frame.lit_by_irradiance = false;              // applies to rendering rays, whatever PIPELINE says
  frame.opacity_threshold = wire::kOpacityOne;  // it ends gathering rays only
  frame.rules = rules;
  if (rules == wire::EnergyRules::kAsPrinted) return;
  frame.jitter = false;  // it hides sample positions; the depth of an interval does not depend on them
  if (!depths_ || depths_of_ != frame.segmentation_writes) depths_.emplace(frame.segmentation);
  depths_of_ = frame.segmentation_writes;
  frame.depths = &*depths_;
}

CommandResult DspCommands::illuminate(std::span<const std::uint8_t> payload, Progress& work) {
  expect(payload.size() == wire::kIlluminateCommandBytes, "payload", "104 bytes", payload.size());
  const auto command = wire::decode<wire::IlluminateCommand>(payload);
  check_volume();
  const bool waits = in_bricks();
  if (!waits) check_all_there();
  Frame frame = this->frame();
  check_materials(!waits && frame.light_words == 1);
  if (const auto what = LightingRays::fault(command, frame.extent)) refuse(*what);
  set_light(frame, command.rules);
  for (std::uint32_t word = 0; frame.light_words > 1 && word < kColours; ++word) {
    frame.light_colour[word] = static_cast<std::uint16_t>(registers_.value(wire::reg::kLightRed + 4 * word));
  }
  if (waits && !goes_on_) {
    drop_rays();
    waiting_rays_.begin(WaitingKind::kLight, {.type = wire::RayType::kDeposit, .rules = command.rules});
  }
  if (waits) set_bricks(frame);
  expect_memory(frame);
  if (!goes_on_) host_traps_.begin(true, command.rules);
  const unsigned bits = frame.wide ? 24 : command.albedo == wire::Albedo::kHigh ? 4 : 8;  // [P §4.2]
  aperture_.decode(threads_, reads(frame));
  const LightingRays maker(command, frame.extent, frame.spacing, bits, frame.seed);
  LightRays rays(maker, frame);
  const RunResult ran = run_level(rays, frame, work);
  lighting_rays_ += ran.made;
  CommandResult result{.dsp_cycles = ran.dsp_cycles, .asic_ps = ran.asic_ps};
  add_ledger(result, ran.rays, light_in_solid(command, frame));
  add_waiting(result);
  add_trap_list(result, 0);
  return result;
}

}  // namespace gicube::emu
