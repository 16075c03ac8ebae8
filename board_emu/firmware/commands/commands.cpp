#include "commands.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <thread>

#include "approximate/approximate_level.h"
#include "command_fault.h"
#include "cycle/cycle_level.h"
#include "cycle/machine_counters.h"
#include "datapath/advance.h"
#include "datapath/interaction.h"
#include "firmware/lighting_rays.h"
#include "firmware/routines.h"
#include "functional/functional_level.h"
#include "gicube/wire/command.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;
namespace reg = wire::reg;

// Opaque where the light is: all it sends out stays there.
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

// Adds counters to those of the same names.
void add(const std::vector<wire::Counter>& from, std::vector<wire::Counter>& to) {
  for (const wire::Counter& counter : from) {
    const auto known = std::find_if(to.begin(), to.end(), [&](const auto& c) { return c.name == counter.name; });
    if (known == to.end()) {
      to.push_back(counter);
    } else {
      known->value += counter.value;
    }
  }
}

std::uint32_t max_irradiance(const v1::BoardConfig& config) {
  return config.asic().datapath() == v1::wide ? IrradianceMemory::kWideMost : IrradianceMemory::kPaperMost;
}

}  // namespace

DspCommands::DspCommands(const v1::BoardConfig& config, const RegisterFile& registers)
    : config_(config),
      registers_(registers),
      threads_(config.threads() != 0 ? config.threads() : std::max(1u, std::thread::hardware_concurrency())),
      aperture_(static_cast<int>(config.asic().block_voxels()), max_irradiance(config)) {}

void DspCommands::clear_volume() {
  std::array<int, 3> size{};
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    size[axis] = static_cast<int>(registers_.value(reg::kVolumeX + 4 * axis));
  const bool complete = std::all_of(size.begin(), size.end(), [](int edge) { return edge > 0; });
  aperture_.resize_volume(complete ? size : std::array<int, 3>{});
  packets_.clear();
}

void DspCommands::clear_irradiance() {
  aperture_.irradiance().clear();
  if (machine_) machine_->invalidate_caches();
}

void DspCommands::clear_sums() {
  aperture_.sums().clear();
  if (machine_) machine_->invalidate_caches();
}

void DspCommands::reset() {
  drop_machine();
  host_traps_.begin(false, {});
  memory_errors_.clear();
  aperture_ = Aperture(static_cast<int>(config_.asic().block_voxels()), max_irradiance(config_));
  packets_.clear();
  wide_depths_of_ = ~std::uint64_t{0};
}

// The next command begins with a new machine; the counters go on.
void DspCommands::drop_machine() {
  const auto keep_counters = [&](const auto& machine) {
    std::vector<wire::Counter> list;
    machine(list);
    add(list, past_);
  };
  if (machine_) {
    rays_ += ray_counters(*machine_);
    keep_counters([&](auto& list) { emu::count(*machine_, list); });
    machine_.reset();
  }
  if (pass_machine_) {
    keep_counters([&](auto& list) { pass_machine_->count(list); });
    pass_machine_.reset();
  }
}

PassMachine& DspCommands::pass_machine() {
  const VolumeMemory& volume = aperture_.volume();
  if (pass_machine_ && pass_machine_->blocks() != volume.blocks()) drop_machine();
  if (!pass_machine_) pass_machine_ = std::make_unique<PassMachine>(config_, volume.blocks());
  if (turns_volume_ != aperture_.volume_writes()) pass_machine_->invalidate_caches();
  turns_volume_ = aperture_.volume_writes();
  return *pass_machine_;
}

Machine& DspCommands::machine(bool sums) {
  const VolumeMemory& volume = aperture_.volume();
  if (machine_ && machine_->blocks() != volume.blocks()) drop_machine();
  if (!machine_) {
    machine_ = std::make_unique<Machine>(config_, volume.blocks());
    machine_->set_observer(observer_);
  }
  if (cached_volume_ != aperture_.volume_writes() || cached_sums_ != sums) machine_->invalidate_caches();
  cached_volume_ = aperture_.volume_writes();
  cached_sums_ = sums;
  return *machine_;
}

// Rays are left on the ASIC: it goes.
CommandResult DspCommands::cancelled() {
  drop_machine();
  return {.error = ErrorCode::kCancelled};
}

CommandResult DspCommands::timed(const RunResult& ran) const {
  return {.dsp_cycles = ran.dsp_cycles, .asic_ps = cycles_to_ps(ran.cycles, config_.asic().core_khz())};
}

bool DspCommands::accept_register(std::uint32_t offset) {
  const std::uint32_t value = registers_.value(offset);
  const auto within = [value](std::uint32_t low, std::uint32_t high) { return value >= low && value <= high; };
  switch (offset) {
    case reg::kVolumeX:
    case reg::kVolumeY:
    case reg::kVolumeZ:
      if (!within(2, config_.asic().max_volume_voxels())) return false;
      clear_volume();
      return true;
    case reg::kSpacingX:
    case reg::kSpacingY:
    case reg::kSpacingZ: return within(wire::kSpacingOne / 64, wire::kSpacingMax);
    case reg::kStep: return within(wire::kStepMin, wire::kStepMax);
    case reg::kOpacityThreshold: return within(0, wire::kOpacityOne);
    case reg::kPipeline: return within(0, wire::kPipelineBits);
    case reg::kLifetime: return within(0, wire::kLifetimeMax);
    case reg::kCutPlanes: return within(0, wire::kMaxCutPlanes);
    default: return true;
  }
}

// What is wrong with a material that the host wrote, if anything.
std::optional<std::string> DspCommands::material_fault(bool host_answers) const {
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    const wire::Material& material = aperture_.materials()[tag];
    const std::string which = "material " + std::to_string(tag) + ": ";
    if (material.bsdf > wire::Bsdf::kTrap) {
      return which + expected("bsdf", "0..6", static_cast<std::uint64_t>(material.bsdf));
    }
    if (material.parameter_count > wire::kMaterialParameters) {
      return which + expected("parameters", "at most 32", material.parameter_count);
    }
    if (material.bsdf != wire::Bsdf::kTrap) continue;
    if (material.routine == wire::kHostRoutine) {
      if (!host_answers) return which + "routine 255: the host is not asked for rays of a trace command";
      continue;
    }
    if (routines_ == nullptr || !routines_->has(material.routine)) {
      return which + expected("routine", "the number of a routine that the board has", material.routine);
    }
    const auto what =
        routines_->fault(material.routine, std::span(material.parameters).first(material.parameter_count));
    if (what) return which + *what;
  }
  return std::nullopt;
}

std::span<const float> DspCommands::current_wide_depths() {
  if (wide_depths_of_ != aperture_.segmentation_writes()) wide_depths_ = wide_depths(aperture_.segmentation());
  wide_depths_of_ = aperture_.segmentation_writes();
  return wide_depths_;
}

Frame DspCommands::frame() {
  Frame frame;
  const VolumeMemory& volume = aperture_.volume();
  frame.volume = &volume;
  frame.segmentation = aperture_.segmentation();
  frame.reflectance_map = aperture_.reflectance_map();
  frame.opacity_correction = &opacity_correction_;
  frame.step = registers_.value(reg::kStep);
  frame.opacity_threshold = registers_.value(reg::kOpacityThreshold);
  const std::uint32_t pipeline = registers_.value(reg::kPipeline);
  frame.jitter = (pipeline & wire::kPipelineJitter) != 0;
  frame.shade = (pipeline & wire::kPipelineShade) != 0;
  frame.leap = (pipeline & wire::kPipelineLeap) != 0;
  frame.lit_by_irradiance = (pipeline & wire::kPipelineIrradiance) != 0;
  frame.scatter = (pipeline & wire::kPipelineScatter) != 0;
  frame.high_albedo = (pipeline & wire::kPipelineHighAlbedo) != 0;
  frame.plain = !frame.lit_by_irradiance && !frame.scatter && !frame.high_albedo;
  std::copy_n(aperture_.materials().begin(), wire::kTags, frame.materials.begin());
  frame.irradiance = &aperture_.irradiance();
  frame.routines = routines_;
  frame.host_traps = &host_traps_;
  frame.wide = config_.asic().datapath() == v1::wide;
  if (frame.wide) frame.wide_depths = current_wide_depths();
  frame.exposure = registers_.value(reg::kExposure);
  frame.seed = registers_.value(reg::kSeed);
  frame.lifetime = static_cast<std::uint16_t>(registers_.value(reg::kLifetime));
  for (std::uint32_t axis = 0; axis < 3; ++axis) {
    frame.extent[axis] = (volume.size()[axis] - 1) * wire::kVoxel;
    frame.spacing[axis] = registers_.value(reg::kSpacingX + 4 * axis);
  }
  frame.empty.resize(volume.block_count());
  for (std::size_t block = 0; block < frame.empty.size(); ++block) frame.empty[block] = aperture_.empty(block) ? 1 : 0;
  for (std::uint32_t i = 0; i < registers_.value(reg::kCutPlanes); ++i) {
    Plane plane;
    const std::uint32_t at = reg::kCutPlane0 + 16 * i;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
      plane.normal[axis] = static_cast<std::int16_t>(registers_.value(at + 4 * axis));
    }
    const auto offset = static_cast<std::int32_t>(registers_.value(at + 12));
    plane.offset = std::int64_t{offset} * (std::int64_t{1} << (kPlaneFractionBits - wire::kCutOffsetFractionBits));
    frame.cut_planes.push_back(plane);
  }
  return frame;
}

const SimdTracer* DspCommands::packets(std::uint64_t rays, const Frame& frame) {
  return packets_.prepare(rays, frame, aperture_.segmentation_writes(), threads_) ? &packets_ : nullptr;
}

CommandResult DspCommands::run(std::span<const std::uint8_t> payload, Progress& work) {
  const std::uint32_t opcode = payload.size() >= 4 ? wire::load<std::uint32_t>(payload, 0) : 0;
  const auto first = static_cast<std::uint32_t>(wire::Opcode::kRender);
  const auto last = static_cast<std::uint32_t>(wire::Opcode::kPairs);
  if (!memory_errors_.empty() && opcode >= first && opcode <= last) return meet_memory_error();
  try {
    if (opcode == static_cast<std::uint32_t>(wire::Opcode::kRender)) return render(payload, work);
    if (opcode == static_cast<std::uint32_t>(wire::Opcode::kTrace)) return trace(payload, work);
    if (opcode == static_cast<std::uint32_t>(wire::Opcode::kIlluminate)) return illuminate(payload, work);
    if (opcode == static_cast<std::uint32_t>(wire::Opcode::kResume)) return resume(payload, work);
    if (opcode == static_cast<std::uint32_t>(wire::Opcode::kVerify)) return verify(payload);
    if (opcode == last) return pairs(payload, work);
  } catch (const RoutineFault& fault) {
    drop_machine();
    return refuse(fault.what());
  } catch (const Stall& stall) {
    drop_machine();
    const std::string text = stall.what();
    return {.error = ErrorCode::kInternal, .payload = std::vector<std::uint8_t>(text.begin(), text.end())};
  }
  return refuse(
      expected("opcode", "1 (render), 2 (trace), 3 (illuminate), 4 (resume), 5 (verify) or 6 (pairs)", opcode));
}

namespace {

std::uint64_t viewing_rays(const wire::RenderCommand& command) {
  return std::uint64_t{command.width} * command.height * command.samples_per_axis * command.samples_per_axis;
}

}  // namespace

CommandResult DspCommands::render(std::span<const std::uint8_t> payload, Progress& work) {
  if (payload.size() != wire::kRenderCommandBytes) return refuse(expected("payload", "112 bytes", payload.size()));
  const auto command = wire::decode_render(payload.first<wire::kRenderCommandBytes>());
  if (const auto what = fault(command, config_.dsp().framebuffer_mb())) return refuse(*what);
  if (!has_volume()) return refuse(kNoVolume);
  if (const auto what = material_fault()) return refuse(*what);

  host_traps_.begin(false, {});
  const Frame frame = this->frame();
  aperture_.decode(threads_, reads(frame));
  const v1::DspConfig& dsp = config_.dsp();
  CommandResult result;
  if (in_cycles(frame)) {
    const RunResult ran = emu::render(command, frame, aperture_.framebuffer(), dsp, machine(), work);
    if (ran.cancelled) return cancelled();
    result = timed(ran);
  } else if (in_turns(frame)) {
    const RunResult ran = emu::render(command, frame, aperture_.framebuffer(), dsp,
                                      packets(viewing_rays(command), frame), threads_, pass_machine(), rays_, work);
    if (ran.cancelled) return cancelled();
    result = timed(ran);
  } else {
    const Rendered rendered =
        emu::render(command, frame, aperture_.framebuffer(), packets(viewing_rays(command), frame), threads_, work);
    if (rendered.cancelled) return {.error = ErrorCode::kCancelled};
    rays_ += rendered.rays;
    result.dsp_cycles = rendered.made * dsp.viewing_ray_cycles() + rendered.returned * dsp.returned_ray_cycles() +
                        rendered.rays.trap_cycles;
  }
  aperture_.resolve_framebuffer(threads_);
  viewing_rays_ += viewing_rays(command);
  add_trap_list(result, 0);
  return result;
}

CommandResult DspCommands::illuminate(std::span<const std::uint8_t> payload, Progress& work) {
  if (payload.size() != wire::kIlluminateCommandBytes) return refuse(expected("payload", "104 bytes", payload.size()));
  const auto command = wire::decode_illuminate(payload.first<wire::kIlluminateCommandBytes>());
  if (!has_volume()) return refuse(kNoVolume);
  if (const auto what = material_fault()) return refuse(*what);
  Frame frame = this->frame();
  if (const auto what = LightingRays::fault(command, frame.extent)) return refuse(*what);
  host_traps_.begin(true, command.rules);
  aperture_.irradiance().expect_deposits();

  frame.plain = false;
  frame.lights = true;
  frame.opacity_threshold = wire::kOpacityOne;  // it ends rays that gather
  frame.rules = command.rules;
  const unsigned bits = frame.wide ? 24 : command.albedo == wire::Albedo::kHigh ? 4 : 8;  // [P §4.2]
  aperture_.decode(threads_, reads(frame));
  const LightingRays rays(command, frame.extent, frame.spacing, bits, frame.seed);
  CommandResult result;
  RayCounters counts;
  if (in_cycles(frame)) {
    Lit lit;
    const RayCounters before = ray_counters(machine());
    const RunResult ran = emu::illuminate(rays, frame, config_.dsp(), machine(), lit, work);
    if (ran.cancelled) return cancelled();
    counts = ray_counters(machine()) - before;
    counts.energy.emitted = lit.emitted;
    lighting_rays_ += lit.made;
    result = timed(ran);
  } else {
    const Rendered lit = emu::illuminate(rays, frame, threads_, work);
    if (lit.cancelled) return {.error = ErrorCode::kCancelled};
    counts = lit.rays;
    rays_ += counts;
    lighting_rays_ += lit.made;
    result.dsp_cycles = lit.made * config_.dsp().lighting_ray_cycles() + counts.trap_cycles;
  }

  add_ledger(result, counts, light_in_solid(command, frame));
  add_trap_list(result, 0);
  return result;
}

void DspCommands::count(std::vector<wire::Counter>& list) const {
  list.push_back({"dsp.viewing_rays", "ray", viewing_rays_});
  list.push_back({"dsp.host_rays", "ray", host_rays_});
  if (pair_rays_ != 0) list.push_back({"dsp.pair_rays", "ray", pair_rays_});
  RayCounters rays = rays_;
  if (machine_) rays += ray_counters(*machine_);
  list.push_back({"pipeline.rays", "ray", rays.rays});
  list.push_back({"pipeline.samples", "sample", rays.samples});
  list.push_back({"pipeline.visible_samples", "sample", rays.visible_samples});
  list.push_back({"pipeline.leaps", "leap", rays.leaps});
  list.push_back({"pipeline.terminated", "ray", rays.terminated});
  if (lighting_rays_ != 0 || rays.scatterings != 0 || rays.deposits != 0) {
    list.push_back({"dsp.lighting_rays", "ray", lighting_rays_});
    list.push_back({"dsp.trap_cycles", "DSP cycle", rays.trap_cycles});
    list.push_back({"dsp.host_traps", "ray", host_traps_total_});
    list.push_back({"pipeline.scatterings", "scattering", rays.scatterings});
    list.push_back({"pipeline.traps", "ray", rays.traps});
    list.push_back({"pipeline.deposits", "deposit", rays.deposits});
  }
  std::vector<wire::Counter> cycle_level;
  if (machine_) emu::count(*machine_, cycle_level);
  if (pass_machine_) {
    std::vector<wire::Counter> turns;
    pass_machine_->count(turns);
    add(turns, cycle_level);
  }
  add(past_, cycle_level);
  list.insert(list.end(), cycle_level.begin(), cycle_level.end());
}

}  // namespace gicube::emu
