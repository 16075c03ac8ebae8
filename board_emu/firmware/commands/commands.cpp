#include "commands.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "command_fault.h"
#include "datapath/scattering.h"
#include "gicube/parallel_for.h"
#include "gicube/wire/command.h"
#include "words/scope_exit.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;
namespace reg = wire::reg;

std::uint32_t max_irradiance(const v1::BoardConfig& config) {
  return config.asic().datapath() == v1::wide ? IrradianceMemory::kWideMost : IrradianceMemory::kPaperMost;
}

Aperture make_aperture(const v1::BoardConfig& config) {
  return Aperture(static_cast<int>(config.asic().block_voxels()),
                  static_cast<wire::VoxelFormat>(config.asic().voxel_format()), config.asic().irradiance_words(),
                  max_irradiance(config));
}

}  // namespace

DspCommands::DspCommands(const v1::BoardConfig& config, const RegisterFile& registers, Level& level)
    : config_(config),
      registers_(registers),
      level_(level),
      threads_(thread_count(config.threads())),
      aperture_(make_aperture(config)) {}

std::array<int, 3> DspCommands::volume_size() const {
  std::array<int, 3> size{};
  for (std::uint32_t axis = 0; axis < 3; ++axis)
    size[axis] = static_cast<int>(registers_.value(reg::kVolumeX + 4 * axis));
  return std::ranges::all_of(size, [](int edge) { return edge > 0; }) ? size : std::array<int, 3>{};
}

void DspCommands::clear_volume() {
  aperture_.resize_volume(volume_size());
  drop_rays();
  words_bytes_ = 0;
  level_.volume_changed();
}

void DspCommands::clear_irradiance() {
  aperture_.clear_irradiance();
  level_.deposits_cleared();
}

void DspCommands::clear_accumulators() {
  aperture_.accumulators().clear();
  level_.deposits_cleared();
}

void DspCommands::reset() {
  level_.reset();
  host_traps_.begin(false, {});
  drop_rays();
  memory_errors_.clear();
  aperture_.resize_volume({});  // done first, because there may not be memory for both
  words_bytes_ = 0;
  aperture_ = make_aperture(config_);
  wide_depths_of_ = ~std::uint64_t{0};
}

RunResult DspCommands::run_level(RaySource& rays, const Frame& frame, Progress& work) {
  if (level_volume_ != aperture_.volume_writes()) level_.volume_changed();
  level_volume_ = aperture_.volume_writes();
  RunResult ran = level_.run(rays, frame, work);
  if (config_.ideal().dsp() != 0) ran.dsp_cycles = 0;
  if (ran.cancelled) throw CommandFault{ErrorCode::kCancelled, ""};
  ++answered_[static_cast<std::size_t>(ran.answered)][opcode_];
  return ran;
}

// Checks the range of a register's value.
Acceptance DspCommands::range_of(std::uint32_t offset) const {
  const std::uint32_t value = registers_.value(offset);
  const auto within = [value](std::uint32_t low, std::uint32_t high) {
    return value >= low && value <= high ? Acceptance::kTaken : Acceptance::kOutOfRange;
  };
  switch (offset) {
    case reg::kVolumeX:
    case reg::kVolumeY:
    case reg::kVolumeZ: {
      const bool bricks = minor_version_ >= wire::kBricksMinor;
      return within(2, bricks ? wire::kMaxVolumeEdge : config_.asic().max_volume_voxels());
    }
    case reg::kSpacingX:
    case reg::kSpacingY:
    case reg::kSpacingZ: return within(wire::kSpacingOne / 64, wire::kSpacingMax);
    case reg::kStep: return within(wire::kStepMin, wire::kStepMax);
    case reg::kOpacityThreshold: return within(0, wire::kOpacityOne);
    case reg::kPipeline: return within(0, wire::kPipelineBits);
    case reg::kLifetime: return within(0, wire::kLifetimeMax);
    case reg::kCutPlanes: return within(0, wire::kMaxCutPlanes);
    case reg::kBricks: return within(0, 1);
    default: return Acceptance::kTaken;
  }
}

Acceptance DspCommands::accept_register(std::uint32_t offset) {
  const Acceptance accepted = range_of(offset);
  const bool is_size = offset == reg::kVolumeX || offset == reg::kVolumeY || offset == reg::kVolumeZ;
  if (accepted != Acceptance::kTaken || !is_size) return accepted;
  const std::uint64_t bytes =
      Aperture::bytes_of_blocks(volume_size(), config_.asic().block_voxels(), config_.asic().irradiance_words());
  if (!fits(aperture_.image_bytes() + bytes)) return Acceptance::kTooMuchMemory;
  clear_volume();
  return Acceptance::kTaken;
}

void DspCommands::state(Archive& archive) {
  archive("aperture", aperture_);
  archive("host_traps", host_traps_);
  archive("lamps", lamps_);
  const VolumeMemory& volume = aperture_.volume();
  Point extent{};
  for (std::size_t axis = 0; axis < 3; ++axis) extent[axis] = (volume.size()[axis] - 1) * wire::kVoxel;
  archive.within("waiting_rays",
                 [&] { waiting_rays_.state(archive, volume.block_count(), extent, aperture_.host_rays().size()); });
  archive.list("memory_errors", memory_errors_);
  archive.field("counters", [this](Archive::Record& record) {
    record(answered_, viewing_rays_, host_rays_, lighting_rays_, pair_rays_, host_traps_total_, waits_total_,
           block_loads_, min_block_loads_, host_deposits_total_, forwarded_rays_, arrived_rays_);
    record(level_volume_, words_bytes_, memory_asked_bytes_);
  });
  if (!archive.loads()) return;
  archive.expect(volume.size() == volume_size(), "aperture.volume.size", "the VOLUME registers", volume.block_count());
  archive.expect(volume.stored_blocks() <= capacity_blocks(), "aperture.volume.stored",
                 "at most " + std::to_string(capacity_blocks()) + " blocks", volume.stored_blocks());
  for (const wire::RegisterInfo& info : wire::kRegisterTable) {
    const bool is_unset = registers_.value(info.offset) == info.reset;
    archive.expect(is_unset || range_of(info.offset) == Acceptance::kTaken, info.name, "a value that can be written",
                   registers_.value(info.offset));
  }
  const bool has_room = !is_limited() || limited_memory() <= max_memory_bytes_;
  archive.expect(has_room, "aperture", std::to_string(max_memory_mib()) + " MiB (gicube-board --max-memory)",
                 limited_memory());
}

std::uint64_t DspCommands::stored_words() {
  return aperture_.stored_irradiance_bytes() + aperture_.accumulators().stored_bytes();
}

Acceptance DspCommands::write_memory(std::uint64_t address, std::span<const std::uint8_t> bytes) {
  if (is_limited()) {
    const auto [volume, irradiance] = aperture_.bytes_of_write(address, bytes.size());
    const std::uint64_t rest = aperture_.volume_bytes() + aperture_.image_bytes() + rays_bytes() + volume + irradiance;
    const bool more = volume + irradiance > 0;
    if (more && rest + words_bytes_ > max_memory_bytes_) {
      words_bytes_ = stored_words();  // earlier writes reserved more than they needed
      if (!fits(rest + words_bytes_)) return Acceptance::kTooMuchMemory;
    }
    words_bytes_ += irradiance;
  }
  if (!has_room(address, bytes.size())) return Acceptance::kOutOfRange;
  return aperture_.write(address, bytes) ? Acceptance::kTaken : Acceptance::kOutOfRange;
}

// Returns whether the card can store the written blocks. Counts newly loaded blocks.
bool DspCommands::has_room(std::uint64_t address, std::uint64_t length) {
  const VolumeMemory& volume = aperture_.volume();
  const std::uint64_t offset = address - wire::kVolume.base;
  if (address < wire::kVolume.base || length == 0 || offset + length > volume.bytes()) return true;
  const std::uint64_t first = offset / volume.block_bytes(), last = (offset + length - 1) / volume.block_bytes();
  std::uint64_t more = 0;
  for (std::uint64_t block = first; block <= last; ++block) more += volume.is_stored(block) ? 0 : 1;
  if (volume.stored_blocks() + more > capacity_blocks()) return false;
  for (std::uint64_t block = first; in_bricks() && block <= last; ++block) {
    if (volume.is_stored(block)) continue;
    ++block_loads_;
    min_block_loads_ += waiting_rays_.note_load(block, volume.block_count()) ? 1 : 0;
  }
  return true;
}

std::uint32_t DspCommands::max_memory_mib() const {
  constexpr std::uint32_t kNoLimit = ~std::uint32_t{0};
  return is_limited() ? static_cast<std::uint32_t>(std::min<std::uint64_t>(max_memory_bytes_ >> 20, kNoLimit - 1))
                      : kNoLimit;
}

std::uint32_t DspCommands::memory_asked_mib() const {
  return static_cast<std::uint32_t>((memory_asked_bytes_ + (1 << 20) - 1) >> 20);
}

bool DspCommands::fits(std::uint64_t bytes) {
  if (bytes <= max_memory_bytes_) return true;
  memory_asked_bytes_ = bytes;
  return false;
}

void DspCommands::expect_memory(const Frame& frame, std::uint64_t pixels) {
  if (!is_limited()) return;
  const bool accumulates = frame.accumulators != nullptr,
             deposits = frame.lights() || (frame.backprojects() && !accumulates);
  words_bytes_ = stored_words();
  const std::uint64_t more_words = (deposits ? aperture_.free_irradiance_bytes(capacity_blocks()) : 0) +
                                   (accumulates ? aperture_.accumulators().free_bytes() : 0);
  const std::uint64_t decoded = frame.backprojects() ? 0 : aperture_.volume().bytes_to_decode(reads(frame));
  const std::uint64_t image = pixels > 0 ? Aperture::bytes_of_image(pixels) : aperture_.image_bytes();
  const std::uint64_t taken = aperture_.volume_bytes() + words_bytes_ + more_words + decoded + image;
  if (!fits(taken + rays_bytes())) {
    refuse("memory: expected at most " + std::to_string(max_memory_mib()) +
           " MiB for volume, words and image (gicube-board --max-memory), got " + std::to_string(memory_asked_mib()) +
           " MiB");
  }
  words_bytes_ += more_words;
  waiting_rays_.set_room(max_memory_bytes_ - taken - aperture_.host_rays_bytes());
}

void DspCommands::check_volume() const {
  if (aperture_.volume().block_count() == 0) refuse("no volume: VOLUME_X, VOLUME_Y and VOLUME_Z are not all set");
}

void DspCommands::check_materials(bool host_answers) const {
  for (std::size_t tag = 0; tag < wire::kTags; ++tag) {
    const wire::Material& material = aperture_.materials()[tag];
    check_part("material", tag, [&] {
      expect(material.bsdf <= wire::Bsdf::kTrap, "bsdf", "0..6", static_cast<std::uint64_t>(material.bsdf));
      expect(material.parameter_count <= wire::kMaterialParameters, "parameters", "at most 32",
             material.parameter_count);
      if (material.bsdf != wire::Bsdf::kTrap) return;
      if (material.routine == wire::kHostRoutine) {
        if (!host_answers)
          refuse(
              "routine 255: the host is not asked for rays of a trace command, for light in three irradiance words, or "
              "while blocks are absent");
        return;
      }
      expect(routines_ != nullptr && routines_->has(material.routine), "routine",
             "the number of a routine that the board has", material.routine);
      const auto parameters = std::span(material.parameters).first(material.parameter_count);
      if (const auto what = routines_->fault(material.routine, parameters)) refuse(*what);
    });
  }
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
  frame.segmentation_writes = aperture_.segmentation_writes();
  frame.reflectance_map = aperture_.reflectance_map();
  frame.opacity_correction = &opacity_correction_;
  frame.step = registers_.value(reg::kStep);
  frame.opacity_threshold = registers_.value(reg::kOpacityThreshold);
  const std::uint32_t pipeline = registers_.value(reg::kPipeline);
  frame.jitter = (pipeline & wire::kPipelineJitter) != 0;
  frame.shade = (pipeline & wire::kPipelineShade) != 0;
  frame.skip_empty = (pipeline & wire::kPipelineLeap) != 0;
  frame.lit_by_irradiance = (pipeline & wire::kPipelineIrradiance) != 0;
  frame.scatter = (pipeline & wire::kPipelineScatter) != 0;
  frame.high_albedo = (pipeline & wire::kPipelineHighAlbedo) != 0;
  std::copy_n(aperture_.materials().begin(), wire::kTags, frame.materials.begin());
  frame.irradiance = aperture_.irradiance().data();
  frame.light_words = aperture_.irradiance().size();
  for (std::size_t tag = 0; frame.light_words > 1 && tag < wire::kTags; ++tag) {
    for (std::size_t word = 0; word < kColours; ++word) {
      frame.scattering_colour[tag][word] =
          static_cast<std::uint16_t>(wire::kScatteringOne - aperture_.scattering_colours()[tag].lost[word]);
    }
  }
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

CommandResult DspCommands::run(std::span<const std::uint8_t> payload, Progress& work) {
  const auto error = [](ErrorCode code, const std::string& text) {
    return CommandResult{.error = code, .payload = {text.begin(), text.end()}};
  };
  using wire::Opcode;
  const std::uint32_t opcode = payload.size() >= 4 ? wire::load<std::uint32_t>(payload, 0) : 0;
  const bool known = opcode >= 1 && opcode < wire::kOpcodeNames.size();
  goes_on_ = level_.in_run();
  const ScopeExit ended{[this] {
    if (level_.in_run()) level_.reset();  // the checkpoint's command was not this one
  }};
  try {
    if (known && !memory_errors_.empty()) meet_memory_error();
    if (known) opcode_ = opcode;
    switch (static_cast<Opcode>(opcode)) {
      case Opcode::kRender: return render(payload, work);
      case Opcode::kTrace: return trace(payload, work);
      case Opcode::kIlluminate: return illuminate(payload, work);
      case Opcode::kResume: return resume(payload, work);
      case Opcode::kVerify: return verify(payload, work);
      case Opcode::kPairs: return pairs(payload, work);
      case Opcode::kContinue: return continue_rays(payload, work);
      case Opcode::kTakeRays: return take_rays(payload);
      case Opcode::kGiveRays: return give_rays(payload);
      case Opcode::kLoadCoarse: return load_coarse(payload);
    }
    refuse("opcode",
           "1 (render), 2 (trace), 3 (illuminate), 4 (resume), 5 (verify), 6 (pairs), 7 (continue), 8 (take rays), 9 "
           "(give "
           "rays) or 10 (load coarse)",
           opcode);
  } catch (const CommandFault& fault) {
    return error(fault.error, fault.text);
  } catch (const RoutineFault& fault) {
    return error(ErrorCode::kBadValue, fault.what());
  } catch (const Stall& stall) {
    return error(ErrorCode::kInternal, stall.what());
  } catch (const std::runtime_error& fault) {
    if (!goes_on_) throw;
    return error(ErrorCode::kInternal, fault.what());  // CheckpointFault, or caused by a ray of a forged checkpoint
  }
}

void DspCommands::count(std::vector<wire::Counter>& list) const {
  list.push_back({"dsp.viewing_rays", "ray", viewing_rays_});
  list.push_back({"dsp.host_rays", "ray", host_rays_});
  if (pair_rays_ != 0) list.push_back({"dsp.pair_rays", "ray", pair_rays_});
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    const std::string name = "fidelity_answered." + v1::FidelityLevel_Name(level);
    const auto& counts = answered_[static_cast<std::size_t>(level)];
    list.push_back({name, "command", std::accumulate(counts.begin(), counts.end(), std::uint64_t{0})});
    for (std::size_t opcode = 0; opcode < counts.size(); ++opcode) {
      if (counts[opcode] != 0) list.push_back({name + '.' + wire::kOpcodeNames[opcode], "command", counts[opcode]});
    }
  }
  if (config_.fidelity() != v1::functional) list.push_back({"emulator.cycles_ahead", "cycle", level_.cycles_ahead()});
  if (waits_total_ != 0) {
    list.push_back({"dsp.waits", "ray", waits_total_});
    list.push_back({"dsp.block_loads", "block", block_loads_});
    list.push_back({"dsp.min_block_loads", "block", min_block_loads_});
    list.push_back({"dsp.host_deposits", "voxel", host_deposits_total_});
  }
  if (forwarded_rays_ != 0 || arrived_rays_ != 0) {
    list.push_back({"dsp.forwarded_rays", "ray", forwarded_rays_});
    list.push_back({"dsp.arrived_rays", "ray", arrived_rays_});
  }
  const RayCounters rays = level_.rays();
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
  level_.count(list);
}

}  // namespace gicube::emu
