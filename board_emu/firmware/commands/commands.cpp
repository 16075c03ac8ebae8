// Execution of commands; counters and checkpoint fields of the card.
#include <algorithm>
#include <array>
#include <numeric>
#include <string>

#include "command_fault.h"
#include "datapath/scattering.h"
#include "each_command.h"
#include "gicube/wire/command.h"
#include "words/scope_exit.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;

// By opcode.
constexpr std::array<Command*, wire::kOpcodeNames.size()> kCommands{
    nullptr,     render_image,  trace_rays, illuminate_volume, resume_rays, verify_blocks,
    trace_pairs, continue_rays, take_rays,  give_rays,         load_coarse};

std::string known_opcodes() {
  std::string out;
  for (std::size_t opcode = 1; opcode < kCommands.size(); ++opcode) {
    if (opcode > 1) out += opcode + 1 < kCommands.size() ? ", " : " or ";
    out += std::to_string(opcode) + " (" + wire::kOpcodeNames[opcode] + ')';
  }
  return out;
}

}  // namespace

void Card::state(Archive& archive) {
  archive("aperture", aperture);
  archive("host_traps", host_traps);
  archive("lamps", lamps);
  const VolumeMemory& volume = aperture.volume();
  Point extent{};
  for (std::size_t axis = 0; axis < 3; ++axis) extent[axis] = (volume.size()[axis] - 1) * wire::kVoxel;
  archive.within("waiting_rays",
                 [&] { waiting_rays.state(archive, volume.block_count(), extent, aperture.host_rays().size()); });
  archive.list("memory_errors", memory_errors);
  archive.field("counters", [this](Archive::Record& record) {
    record(answered, viewing_rays, host_rays, lighting_rays, pair_rays, host_traps_total, waits_total, block_loads,
           min_block_loads, host_deposits_total, forwarded_rays, arrived_rays);
    record(level_volume, words_bytes, limit.asked);
  });
  if (!archive.loads()) return;
  archive.expect(volume.size() == volume_size(), "aperture.volume.size", "the VOLUME registers", volume.block_count());
  archive.expect(volume.stored_blocks() <= capacity_blocks(), "aperture.volume.stored",
                 "at most " + std::to_string(capacity_blocks()) + " blocks", volume.stored_blocks());
  for (const wire::RegisterInfo& info : wire::kRegisterTable) {
    const bool is_unset = registers.value(info.offset) == info.reset;
    archive.expect(is_unset || range_of(info.offset) == Acceptance::kTaken, info.name, "a value that can be written",
                   registers.value(info.offset));
  }
  const bool has_room = !limit.is_set() || limited_memory() <= limit.max();
  archive.expect(has_room, "aperture", std::to_string(limit.max_mib()) + " MiB (gicube-board --max-memory)",
                 limited_memory());
}

CommandResult Card::run(Payload payload, Progress& work) {
  const auto error = [](ErrorCode code, const std::string& text) {
    return CommandResult{.error = code, .payload = {text.begin(), text.end()}};
  };
  const std::uint32_t number = payload.size() >= 4 ? wire::load<std::uint32_t>(payload, 0) : 0;
  goes_on = level.in_run();
  const ScopeExit ended{[this] {
    if (level.in_run()) level.reset();  // the checkpoint's command was not this one
  }};
  try {
    if (number < 1 || number >= kCommands.size()) refuse("opcode", known_opcodes(), number);
    if (!memory_errors.empty()) report_memory_error();
    opcode = number;
    return kCommands[opcode](*this, payload, work);
  } catch (const CommandFault& fault) {
    return error(fault.error, fault.text);
  } catch (const RoutineFault& fault) {
    return error(ErrorCode::kBadValue, fault.what());
  } catch (const Stall& stall) {
    return error(ErrorCode::kInternal, stall.what());
  } catch (const std::runtime_error& fault) {
    if (!goes_on) throw;
    return error(ErrorCode::kInternal, fault.what());  // CheckpointFault, or caused by a ray of a forged checkpoint
  }
}

void Card::count(std::vector<wire::Counter>& list) const {
  list.push_back({"dsp.viewing_rays", "ray", viewing_rays});
  list.push_back({"dsp.host_rays", "ray", host_rays});
  if (pair_rays != 0) list.push_back({"dsp.pair_rays", "ray", pair_rays});
  for (const v1::FidelityLevel answering : {v1::functional, v1::cycle}) {
    const std::string name = "fidelity_answered." + v1::FidelityLevel_Name(answering);
    const auto& counts = answered[static_cast<std::size_t>(answering)];
    list.push_back({name, "command", std::accumulate(counts.begin(), counts.end(), std::uint64_t{0})});
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] != 0) list.push_back({name + '.' + wire::kOpcodeNames[i], "command", counts[i]});
    }
  }
  if (config.fidelity() != v1::functional) list.push_back({"emulator.cycles_ahead", "cycle", level.cycles_ahead()});
  if (waits_total != 0) {
    list.push_back({"dsp.waits", "ray", waits_total});
    list.push_back({"dsp.block_loads", "block", block_loads});
    list.push_back({"dsp.min_block_loads", "block", min_block_loads});
    list.push_back({"dsp.host_deposits", "voxel", host_deposits_total});
  }
  if (forwarded_rays != 0 || arrived_rays != 0) {
    list.push_back({"dsp.forwarded_rays", "ray", forwarded_rays});
    list.push_back({"dsp.arrived_rays", "ray", arrived_rays});
  }
  const RayCounters rays = level.rays();
  list.push_back({"pipeline.rays", "ray", rays.rays});
  list.push_back({"pipeline.samples", "sample", rays.samples});
  list.push_back({"pipeline.visible_samples", "sample", rays.visible_samples});
  list.push_back({"pipeline.leaps", "leap", rays.leaps});
  list.push_back({"pipeline.terminated", "ray", rays.terminated});
  if (lighting_rays != 0 || rays.scatterings != 0 || rays.deposits != 0) {
    list.push_back({"dsp.lighting_rays", "ray", lighting_rays});
    list.push_back({"dsp.trap_cycles", "DSP cycle", rays.trap_cycles});
    list.push_back({"dsp.host_traps", "ray", host_traps_total});
    list.push_back({"pipeline.scatterings", "scattering", rays.scatterings});
    list.push_back({"pipeline.traps", "ray", rays.traps});
    list.push_back({"pipeline.deposits", "deposit", rays.deposits});
  }
  level.count(list);
}

}  // namespace gicube::emu
