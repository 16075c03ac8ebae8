#include "commands.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "command_fault.h"
#include "datapath/scattering.h"
#include "gicube/wire/command.h"
#include "words/scope_exit.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;
namespace reg = wire::reg;

}  // namespace

DspCommands::DspCommands(const v1::BoardConfig& config, const RegisterFile& registers, Level& level)
    : card_(config, registers, level) {}

void DspCommands::clear_irradiance() {
  card_.aperture.clear_irradiance();
  card_.level.deposits_cleared();
}

void DspCommands::clear_accumulators() {
  card_.aperture.accumulators().clear();
  card_.level.deposits_cleared();
}

void DspCommands::reset() {
  card_.level.reset();
  card_.host_traps.begin(false, {});
  card_.drop_rays();
  memory_errors_.clear();
  card_.aperture.resize_volume({});  // done first, because there may not be memory for both
  card_.words_bytes = 0;
  card_.aperture = make_aperture(card_.config);
  card_.tables.clear();
}

// Checks the range of a register's value.
Acceptance DspCommands::range_of(std::uint32_t offset) const {
  const std::uint32_t value = card_.registers.value(offset);
  const auto within = [value](std::uint32_t low, std::uint32_t high) {
    return value >= low && value <= high ? Acceptance::kTaken : Acceptance::kOutOfRange;
  };
  switch (offset) {
    case reg::kVolumeX:
    case reg::kVolumeY:
    case reg::kVolumeZ: {
      const bool bricks = card_.minor_version >= wire::kBricksMinor;
      return within(2, bricks ? wire::kMaxVolumeEdge : card_.config.asic().max_volume_voxels());
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
  const std::uint64_t bytes = Aperture::bytes_of_blocks(card_.volume_size(), card_.config.asic().block_voxels(),
                                                        card_.config.asic().irradiance_words());
  if (!card_.limit.fits(card_.aperture.image_bytes() + bytes)) return Acceptance::kTooMuchMemory;
  card_.clear_volume();
  return Acceptance::kTaken;
}

void DspCommands::state(Archive& archive) {
  archive("aperture", card_.aperture);
  archive("host_traps", card_.host_traps);
  archive("lamps", card_.lamps);
  const VolumeMemory& volume = card_.aperture.volume();
  Point extent{};
  for (std::size_t axis = 0; axis < 3; ++axis) extent[axis] = (volume.size()[axis] - 1) * wire::kVoxel;
  archive.within("waiting_rays", [&] {
    card_.waiting_rays.state(archive, volume.block_count(), extent, card_.aperture.host_rays().size());
  });
  archive.list("memory_errors", memory_errors_.waiting());
  archive.field("counters", [this](Archive::Record& record) {
    record(card_.answered, render_.viewing_rays, trace_.host_rays, card_.lighting_rays, pairs_.pair_rays,
           card_.host_traps_total, card_.waits_total, card_.block_loads, card_.min_block_loads,
           card_.host_deposits_total, take_rays_.forwarded_rays, give_rays_.arrived_rays);
    record(card_.level_volume, card_.words_bytes, card_.limit.asked);
  });
  if (!archive.loads()) return;
  archive.expect(volume.size() == card_.volume_size(), "aperture.volume.size", "the VOLUME registers",
                 volume.block_count());
  archive.expect(volume.stored_blocks() <= card_.capacity_blocks(), "aperture.volume.stored",
                 "at most " + std::to_string(card_.capacity_blocks()) + " blocks", volume.stored_blocks());
  for (const wire::RegisterInfo& info : wire::kRegisterTable) {
    const bool is_unset = card_.registers.value(info.offset) == info.reset;
    archive.expect(is_unset || range_of(info.offset) == Acceptance::kTaken, info.name, "a value that can be written",
                   card_.registers.value(info.offset));
  }
  const bool has_room = !card_.limit.is_set() || limited_memory() <= card_.limit.max();
  archive.expect(has_room, "aperture", std::to_string(card_.limit.max_mib()) + " MiB (gicube-board --max-memory)",
                 limited_memory());
}

void DspCommands::drop_blocks() {
  card_.aperture.drop_blocks();
  card_.level.volume_changed();
}

bool DspCommands::drop_block(std::uint32_t block) {
  if (block >= card_.aperture.volume().block_count()) return false;
  card_.aperture.drop_block(block);
  return true;
}

CommandResult DspCommands::run(Payload payload, Progress& work) {
  const auto error = [](ErrorCode code, const std::string& text) {
    return CommandResult{.error = code, .payload = {text.begin(), text.end()}};
  };
  using wire::Opcode;
  const std::uint32_t opcode = payload.size() >= 4 ? wire::load<std::uint32_t>(payload, 0) : 0;
  const bool known = opcode >= 1 && opcode < wire::kOpcodeNames.size();
  card_.goes_on = card_.level.in_run();
  const ScopeExit ended{[this] {
    if (card_.level.in_run()) card_.level.reset();  // the checkpoint's command was not this one
  }};
  try {
    if (known) memory_errors_.expect_none();
    if (known) card_.opcode = opcode;
    switch (static_cast<Opcode>(opcode)) {
      case Opcode::kRender: return render_.run(payload, work);
      case Opcode::kTrace: return trace_.run(payload, work);
      case Opcode::kIlluminate: return illuminate_.run(payload, work);
      case Opcode::kResume: return resume_.run(payload, work);
      case Opcode::kVerify: return verify_.run(payload, work);
      case Opcode::kPairs: return pairs_.run(payload, work);
      case Opcode::kContinue: return continue_.run(payload, work);
      case Opcode::kTakeRays: return take_rays_.run(payload);
      case Opcode::kGiveRays: return give_rays_.run(payload);
      case Opcode::kLoadCoarse: return load_coarse_.run(payload);
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
    if (!card_.goes_on) throw;
    return error(ErrorCode::kInternal, fault.what());  // CheckpointFault, or caused by a ray of a forged checkpoint
  }
}

void DspCommands::count(std::vector<wire::Counter>& list) const {
  list.push_back({"dsp.viewing_rays", "ray", render_.viewing_rays});
  list.push_back({"dsp.host_rays", "ray", trace_.host_rays});
  if (pairs_.pair_rays != 0) list.push_back({"dsp.pair_rays", "ray", pairs_.pair_rays});
  for (const v1::FidelityLevel level : {v1::functional, v1::cycle}) {
    const std::string name = "fidelity_answered." + v1::FidelityLevel_Name(level);
    const auto& counts = card_.answered[static_cast<std::size_t>(level)];
    list.push_back({name, "command", std::accumulate(counts.begin(), counts.end(), std::uint64_t{0})});
    for (std::size_t opcode = 0; opcode < counts.size(); ++opcode) {
      if (counts[opcode] != 0) list.push_back({name + '.' + wire::kOpcodeNames[opcode], "command", counts[opcode]});
    }
  }
  if (card_.config.fidelity() != v1::functional)
    list.push_back({"emulator.cycles_ahead", "cycle", card_.level.cycles_ahead()});
  if (card_.waits_total != 0) {
    list.push_back({"dsp.waits", "ray", card_.waits_total});
    list.push_back({"dsp.block_loads", "block", card_.block_loads});
    list.push_back({"dsp.min_block_loads", "block", card_.min_block_loads});
    list.push_back({"dsp.host_deposits", "voxel", card_.host_deposits_total});
  }
  if (take_rays_.forwarded_rays != 0 || give_rays_.arrived_rays != 0) {
    list.push_back({"dsp.forwarded_rays", "ray", take_rays_.forwarded_rays});
    list.push_back({"dsp.arrived_rays", "ray", give_rays_.arrived_rays});
  }
  const RayCounters rays = card_.level.rays();
  list.push_back({"pipeline.rays", "ray", rays.rays});
  list.push_back({"pipeline.samples", "sample", rays.samples});
  list.push_back({"pipeline.visible_samples", "sample", rays.visible_samples});
  list.push_back({"pipeline.leaps", "leap", rays.leaps});
  list.push_back({"pipeline.terminated", "ray", rays.terminated});
  if (card_.lighting_rays != 0 || rays.scatterings != 0 || rays.deposits != 0) {
    list.push_back({"dsp.lighting_rays", "ray", card_.lighting_rays});
    list.push_back({"dsp.trap_cycles", "DSP cycle", rays.trap_cycles});
    list.push_back({"dsp.host_traps", "ray", card_.host_traps_total});
    list.push_back({"pipeline.scatterings", "scattering", rays.scatterings});
    list.push_back({"pipeline.traps", "ray", rays.traps});
    list.push_back({"pipeline.deposits", "deposit", rays.deposits});
  }
  card_.level.count(list);
}

}  // namespace gicube::emu
