// Frames of commands: registers, tables and volume as they are.
#include <algorithm>

#include "card.h"
#include "command_fault.h"

namespace gicube::emu {

namespace {

namespace reg = wire::reg;

}  // namespace

std::span<const float> SegmentationTables::wide_depths(const Aperture& aperture) {
  if (wide_depths_of_ != aperture.segmentation_writes()) wide_depths_ = emu::wide_depths(aperture.segmentation());
  wide_depths_of_ = aperture.segmentation_writes();
  return wide_depths_;
}

const DepthTable& SegmentationTables::depths(const Aperture& aperture) {
  if (depths_of_ != aperture.segmentation_writes()) depths_.emplace(aperture.segmentation());
  depths_of_ = aperture.segmentation_writes();
  return *depths_;
}

Frame Card::frame() {
  Frame frame;
  const VolumeMemory& volume = aperture.volume();
  frame.volume = &volume;
  frame.segmentation = aperture.segmentation();
  frame.segmentation_writes = aperture.segmentation_writes();
  frame.reflectance_map = aperture.reflectance_map();
  frame.opacity_correction = &opacity_correction;
  frame.step = registers.value(reg::kStep);
  frame.opacity_threshold = registers.value(reg::kOpacityThreshold);
  const std::uint32_t pipeline = registers.value(reg::kPipeline);
  frame.jitter = (pipeline & wire::kPipelineJitter) != 0;
  frame.shade = (pipeline & wire::kPipelineShade) != 0;
  frame.skip_empty = (pipeline & wire::kPipelineLeap) != 0;
  frame.lit_by_irradiance = (pipeline & wire::kPipelineIrradiance) != 0;
  frame.scatter = (pipeline & wire::kPipelineScatter) != 0;
  frame.high_albedo = (pipeline & wire::kPipelineHighAlbedo) != 0;
  std::copy_n(aperture.materials().begin(), wire::kTags, frame.materials.begin());
  frame.irradiance = aperture.irradiance().data();
  frame.light_words = aperture.irradiance().size();
  for (std::size_t tag = 0; frame.light_words > 1 && tag < wire::kTags; ++tag) {
    for (std::size_t word = 0; word < kColours; ++word) {
      frame.scattering_colour[tag][word] =
          static_cast<std::uint16_t>(wire::kScatteringOne - aperture.scattering_colours()[tag].lost[word]);
    }
  }
  frame.routines = routines;
  frame.host_traps = &host_traps;
  frame.wide = config.asic().datapath() == v1::wide;
  if (frame.wide) frame.wide_depths = tables.wide_depths(aperture);
  frame.exposure = registers.value(reg::kExposure);
  frame.seed = registers.value(reg::kSeed);
  frame.lifetime = static_cast<std::uint16_t>(registers.value(reg::kLifetime));
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    frame.extent[axis] = (volume.size()[axis] - 1) * wire::kVoxel;
    frame.spacing[axis] = registers.value(reg::kSpacingX + 4 * axis);
  }
  frame.empty = aperture.empty();
  for (std::uint32_t i = 0; i < registers.value(reg::kCutPlanes); ++i) {
    Plane plane;
    const std::uint32_t at = reg::kCutPlane0 + 16 * i;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      plane.normal[axis] = static_cast<std::int16_t>(registers.value(at + 4 * axis));
    }
    const auto offset = static_cast<std::int32_t>(registers.value(at + 12));
    plane.offset = std::int64_t{offset} * (std::int64_t{1} << (kPlaneFractionBits - wire::kCutOffsetFractionBits));
    frame.cut_planes.push_back(plane);
  }
  frame.cut_faces = (pipeline & wire::kPipelineCutFaces) != 0 && !frame.cut_planes.empty();
  return frame;
}

// Configures the frame of a command whose rays deposit energy.
void Card::set_light(Frame& frame, wire::EnergyRules rules) {
  aperture.expect_deposits();
  frame.type = wire::RayType::kDeposit;
  frame.lit_by_irradiance = false;              // applies to rendering rays, whatever PIPELINE says
  frame.opacity_threshold = wire::kOpacityOne;  // it ends gathering rays only
  frame.rules = rules;
  if (rules == wire::EnergyRules::kAsPrinted) return;
  frame.jitter = false;  // it hides sample positions; the depth of an interval does not depend on them
  frame.depths = &tables.depths(aperture);
}

Frame Card::trace_frame(const wire::TraceHeader& header) {
  Frame frame = this->frame();
  if (header.type == wire::RayType::kDeposit) {
    set_light(frame, header.rules);
    frame.cut_planes.clear();  // cut planes only affect viewing
    frame.cut_faces = false;
  } else {
    set_type(frame, header);
  }
  if (header.words == wire::SumWords::kWhole) frame.accumulators = &aperture.accumulators();
  return frame;
}

// Allows the frame's rays to wait if blocks may be non-resident. Deposits in blocks with irradiance at the host go
// there.
void Card::set_bricks(Frame& frame) {
  if (in_bricks() && (frame.lights() || frame.lit_by_irradiance)) {
    expect(frame.light_words == 1, "IRRADIANCE_WORDS", "1 for light in a volume with more blocks than the card stores",
           frame.light_words);
    set_irradiance_at_host(frame);
  }
  if (!aperture.any_non_resident() && waiting_rays.count() == 0 && waiting_rays.continued().empty()) return;
  frame.non_resident = aperture.non_resident();
  frame.waiting = &waiting_rays;
}

void Card::set_irradiance_at_host(Frame& frame) {
  const VolumeMemory& volume = aperture.volume();
  std::uint64_t on_card = 0;
  std::vector<std::uint8_t> at_host = aperture.irradiance_at_host();
  for (std::size_t block = 0; block < at_host.size(); ++block) {
    on_card += at_host[block] == 0 || volume.is_stored(block) ? 1 : 0;
  }
  if (on_card > capacity_blocks()) {
    refuse("dark_flags",
           "clear of at most " + std::to_string(capacity_blocks()) + " blocks, with those that are stored", on_card);
  }
  if (!frame.lights()) return;
  frame.irradiance_at_host = std::move(at_host);
  frame.host_deposits = &aperture.host_deposits();
  if (!goes_on) aperture.host_deposits().begin();
}

// The frame of the commands whose rays wait.
Frame Card::continued_frame() {
  if (waiting_rays.kind() == WaitingKind::kHostRays) return trace_frame(waiting_rays.header());
  Frame frame = this->frame();
  if (waiting_rays.kind() == WaitingKind::kLight) {
    set_light(frame, waiting_rays.header().rules);
  } else {
    frame.lamps = !lamps.empty();
  }
  return frame;
}

}  // namespace gicube::emu
