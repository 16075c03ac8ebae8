#include "board/parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "firmware/make_level.h"
#include "gicube/wire/memory_map.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;
using wire::FrameType;
namespace reg = wire::reg;

// AGP rates in the card's configuration space. A card also supports the slower rates.
std::uint32_t agp_rates(const v1::BusConfig& config) {
  const std::uint32_t rate = BusTiming(config).agp_rate;
  return rate == 0 ? 0 : 2 * rate - 1;
}

Reply refuse_payload(const char* expected, std::span<const std::uint8_t> payload) {
  return refusal_of(ErrorCode::kBadValue, fmt::format("payload: expected {}, got {} bytes", expected, payload.size()));
}

// Accesses of a processor, in dwords on the bus. A memory read is requested with its address and length.
constexpr BusTransaction kRegisterWrite{.kind = TransferKind::kRegisterWrite, .down_bytes = 4};
constexpr BusTransaction kRegisterRead{.kind = TransferKind::kRegisterRead, .down_bytes = 4, .watched = true};
constexpr std::uint64_t kReadRequestBytes = 16;

const char* command_name(std::span<const std::uint8_t> payload) {
  const std::uint32_t opcode = payload.size() >= 4 ? wire::load<std::uint32_t>(payload, 0) : 0;
  return wire::kOpcodeNames[opcode < wire::kOpcodeNames.size() ? opcode : 0];
}

Cargo cargo_at(std::uint64_t address) {
  if (address >= wire::kVolume.base) return Cargo::kVolume;
  if (address >= wire::kHostRayMemory.base) return Cargo::kRays;
  return address >= wire::kFramebuffer.base ? Cargo::kImage : Cargo::kTable;
}

}  // namespace

Reply refusal_of(ErrorCode error, const std::string& text) {
  return {.error = error, .payload = std::vector<std::uint8_t>(text.begin(), text.end())};
}

Board::Parts::Parts(const v1::BoardConfig& board_config, std::uint64_t config_hash, BoardObserver* board_observer,
                    const Routines* routines, std::uint64_t max_memory_bytes)
    : config(board_config),
      observer(board_observer),
      pci(agp_rates(config.bus())),
      level(make_level(config, observer != nullptr ? observer->observer() : nullptr)),
      card(config, registers, *level),
      timeline(BusTiming(config.bus()), config.dsp().clock_khz()),
      energy(config) {
  card.routines = routines;
  card.limit.set(max_memory_bytes);
  if (observer != nullptr) {
    observer->power_up(config);
    card.explained = observer->explained_pixel();
    timeline.set_watcher(observer);
  }
  registers.set_fixed(reg::kId, wire::kIdValue);
  registers.set_fixed(reg::kFidelity, static_cast<std::uint32_t>(config.fidelity()));
  registers.set_fixed(reg::kProcessors, config.asic().processors());
  registers.set_fixed(reg::kBlockVoxels, config.asic().block_voxels());
  registers.set_fixed(reg::kMaxVolumeVoxels, config.asic().max_volume_voxels());
  registers.set_fixed(reg::kVoxelFormat, static_cast<std::uint32_t>(config.asic().voxel_format()));
  registers.set_fixed(reg::kIrradianceWords, config.asic().irradiance_words());
  registers.set_fixed(reg::kQueueRays, config.asic().queue_rays());
  registers.set_fixed(reg::kCoreKhz, config.asic().core_khz());
  registers.set_fixed(reg::kDatapath, static_cast<std::uint32_t>(config.asic().datapath()));
  registers.set_fixed(reg::kMaxMemory, card.limit.max_mib());
  registers.set_fixed(reg::kConfigHashLow, static_cast<std::uint32_t>(config_hash));
  registers.set_fixed(reg::kConfigHashHigh, static_cast<std::uint32_t>(config_hash >> 32));
}

void Board::Parts::control(std::uint32_t bits) {
  if ((bits & wire::kControlReset) != 0) {
    registers.reset();
    card.reset();
  }
  if ((bits & wire::kControlClearVolume) != 0) card.clear_volume();
  if ((bits & wire::kControlClearIrradiance) != 0) card.clear_irradiance();
  if ((bits & wire::kControlClearSums) != 0) card.clear_accumulators();
  if ((bits & wire::kControlDropBlocks) != 0) card.drop_blocks();
  if ((bits & wire::kControlDropRays) != 0) card.drop_rays();
}

Reply Board::Parts::transact_word(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  const bool writes = header.type == FrameType::kConfigWrite || header.type == FrameType::kRegisterWrite;
  if (payload.size() != (writes ? 8u : 4u)) {
    return refuse_payload(writes ? "an offset and a value" : "an offset", payload);
  }
  const auto offset = wire::load<std::uint32_t>(payload, 0);
  const std::uint32_t value = writes ? wire::load<std::uint32_t>(payload, 4) : 0;
  std::vector<std::uint8_t> read(4);
  switch (header.type) {
    case FrameType::kConfigRead: wire::store(std::span(read), 0, pci.read(offset)); break;
    case FrameType::kRegisterRead: wire::store(std::span(read), 0, registers.read(offset)); break;
    case FrameType::kConfigWrite: pci.write(offset, value); return finish(header, kRegisterRead, {});
    default: {
      timeline.add(header.time_ps, next_transaction++, kRegisterWrite);
      const std::uint32_t before = registers.value(offset & (wire::kBar0Bytes - 4));
      if (!registers.write(offset, value)) return {};
      if (offset == reg::kControl) control(value);
      if (offset == reg::kDropBlock && !card.drop_block(value)) registers.raise(wire::kStatusBadValue, offset);
      switch (card.accept_register(offset)) {
        case Acceptance::kTaken: return {};
        case Acceptance::kTooMuchMemory: lack_memory(); break;
        case Acceptance::kOutOfRange: break;
      }
      registers.write(offset, before);
      registers.raise(wire::kStatusBadValue, offset);
      return {};
    }
  }
  return finish(header, kRegisterRead, std::move(read));
}

Reply Board::Parts::read_memory(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  if (payload.size() != 16) return refuse_payload("an address and a length", payload);
  const auto address = wire::load<std::uint64_t>(payload, 0), length = wire::load<std::uint64_t>(payload, 8);
  auto bytes = card.aperture.read(address, length);
  if (!bytes)
    return refusal_of(ErrorCode::kBadAddress,
                      fmt::format("address: expected that of {} bytes of readable memory, got {}", length, address));
  // The DSP sends the bytes as bus master when all earlier commands are done.
  const BusTransaction transaction{.kind = TransferKind::kRegisterWrite,
                                   .down_bytes = kReadRequestBytes,
                                   .dsp = true,
                                   .up_bytes = length,
                                   .up_cargo = cargo_at(address),
                                   .watched = true,
                                   .name = kReadMemory};
  return finish(header, transaction, std::move(*bytes));
}

void Board::Parts::write_memory(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  if (payload.size() < 8) return registers.raise(wire::kStatusBadCommand, 0);
  const auto address = wire::load<std::uint64_t>(payload, 0);
  const auto bytes = payload.subspan(8);
  timeline.add(header.time_ps, next_transaction++, {.cargo = cargo_at(address), .down_bytes = bytes.size()});
  const Acceptance accepted = card.write_memory(address, bytes);
  if (accepted == Acceptance::kTaken) return;
  if (accepted == Acceptance::kTooMuchMemory) lack_memory();
  registers.raise(wire::kStatusBadAddress, static_cast<std::uint32_t>(address));
}

// Set in addition to the bit for the refused write, so that drivers that do not support this bit also detect the
// refusal.
void Board::Parts::lack_memory() {
  registers.set_fixed(reg::kMemoryAsked, card.limit.asked_mib());
  registers.raise(wire::kStatusNoMemory, 0);
}

bool Board::Parts::command(const wire::FrameHeader& header, std::span<const std::uint8_t> payload, Progress& work) {
  if (tickets.contains(header.id)) {
    registers.raise(wire::kStatusBadCommand, 0);
    return false;
  }
  carried = {header, payload};
  if (observer != nullptr && observer->places_cycles()) {
    observer->begin_command(timeline.turn_of(header.time_ps, {.down_bytes = payload.size()}), header.id);
  }
  CommandResult result = card.run(payload, work);
  carried.reset();
  if (observer != nullptr) observer->end_command();
  if (result.error != ErrorCode::kNone) {
    registers.raise(result.error == ErrorCode::kMemory ? wire::kStatusMemory : wire::kStatusBadCommand, 0);
  }
  const std::uint64_t id = next_transaction++;
  timeline.add(header.time_ps, id,
               {.cargo = result.takes_rays ? Cargo::kRays : Cargo::kCommand,
                .down_bytes = payload.size(),
                .dsp = true,
                .dsp_cycles = result.dsp_cycles,
                .asic_ps = result.asic_ps,
                .up_bytes = result.up_bytes,
                .up_cargo = result.returns_rays ? Cargo::kRays : Cargo::kCompletion,
                .watched = true,
                .name = command_name(payload)});
  result_bytes += result.payload.capacity();
  under_way[id] = {header.id, result.error, 0, std::move(result.payload), result.leaves_nothing};
  tickets[header.id] = id;
  if (observer != nullptr && observer->wants_counters()) observer->counted(count());
  return true;
}

Reply Board::Parts::wait(std::span<const std::uint8_t> payload) {
  if (payload.size() != 4 && payload.size() != 12) {
    return refuse_payload("a ticket, or a ticket and a deadline", payload);
  }
  const auto ticket = wire::load<std::uint32_t>(payload, 0);
  const Picoseconds deadline = payload.size() == 12 ? wire::load<std::uint64_t>(payload, 4) : kNever;
  const auto found = tickets.find(ticket);
  if (found == tickets.end())
    return refusal_of(ErrorCode::kBadValue, fmt::format("ticket: expected one of a command under way, got {}", ticket));
  if (const auto time = timeline.finish(found->second, std::max(deadline, timeline.now()))) return {.time_ps = *time};
  Reply late = refusal_of(ErrorCode::kDeadline, fmt::format("ticket {} has not completed by {} ps", ticket, deadline));
  late.time_ps = timeline.now();
  return late;
}

// Costs a processor's access, like that of a register. Meanwhile the DSP searches its list.
Reply Board::Parts::cancel(const wire::FrameHeader& header, std::span<const std::uint8_t> payload) {
  if (payload.size() != 4) return refuse_payload("a ticket", payload);
  const auto found = tickets.find(wire::load<std::uint32_t>(payload, 0));
  const bool cancelled = found != tickets.end() && under_way.at(found->second).can_be_cancelled &&
                         timeline.take_back(header.time_ps, found->second);
  if (cancelled) {
    Completion& completion = under_way.at(found->second);
    completion.error = ErrorCode::kCancelled;
    const std::string text = "cancelled by the host";
    result_bytes -= completion.payload.capacity();
    completion.payload = {text.begin(), text.end()};
    result_bytes += completion.payload.capacity();
  }
  std::vector<std::uint8_t> answer(4);
  wire::store(std::span(answer), 0, std::uint32_t{cancelled});
  return finish(header, kRegisterRead, std::move(answer));
}

std::vector<Completion> Board::Parts::take_completions() {
  std::vector<Completion> completions;
  for (const TimeOf& finished : timeline.take_finished()) {
    const auto found = under_way.find(finished.id);
    if (found == under_way.end()) continue;
    completions.push_back(std::move(found->second));
    completions.back().time_ps = finished.time_ps;
    result_bytes -= completions.back().payload.capacity();
    tickets.erase(completions.back().ticket);
    under_way.erase(found);
  }
  return completions;
}

}  // namespace gicube::emu
