#include "board.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>

#include "firmware/commands/commands.h"
#include "firmware/make_level.h"
#include "firmware/register_file.h"
#include "firmware/routines/routine_table.h"
#include "gicube/wire/memory_map.h"
#include "timeline.h"
#include "words/finally.h"

namespace gicube::emu {

namespace {

using wire::ErrorCode;
using wire::FrameType;
namespace reg = wire::reg;

// As the card's configuration space has them; a faster card can also go slower.
std::uint32_t agp_rates(const v1::BusConfig& config) {
  const std::uint32_t rate = BusTiming(config).agp_rate;
  return rate == 0 ? 0 : 2 * rate - 1;
}

bool posted(FrameType type) {
  return type == FrameType::kRegisterWrite || type == FrameType::kMemoryWrite || type == FrameType::kCommand;
}

Reply refuse(ErrorCode error, const std::string& text) {
  return {.error = error, .payload = std::vector<std::uint8_t>(text.begin(), text.end())};
}

Reply refuse_payload(const char* expected, std::span<const std::uint8_t> payload) {
  return refuse(ErrorCode::kBadValue, fmt::format("payload: expected {}, got {} bytes", expected, payload.size()));
}

// A processor's accesses, in dwords on the bus; a memory read is asked for by its address and length.
constexpr BusTransaction kRegisterWrite{.kind = TransferKind::kRegisterWrite, .down_bytes = 4};
constexpr BusTransaction kRegisterRead{.kind = TransferKind::kRegisterRead, .down_bytes = 4, .watched = true};
constexpr std::uint64_t kReadRequestBytes = 16;

// A stamp beyond this is refused, so that no sum of times can run over: 2^62 ps are 53 days.
constexpr Picoseconds kEndOfTime = Picoseconds{1} << 62;

const char* command_name(std::span<const std::uint8_t> payload) {
  const std::uint32_t opcode = payload.size() >= 4 ? wire::load<std::uint32_t>(payload, 0) : 0;
  return wire::kOpcodeNames[opcode < wire::kOpcodeNames.size() ? opcode : 0];
}

const char* wait_name(FrameType type) {
  if (type == FrameType::kMemoryRead) return kReadMemory;
  return type == FrameType::kWait ? "wait" : "access register";
}

Cargo cargo_at(std::uint64_t address) {
  if (address >= wire::kVolume.base) return Cargo::kVolume;
  return address >= wire::kFramebuffer.base ? Cargo::kImage : Cargo::kTable;
}

// chosen: above what the maps and queues take of a transaction that is under way, and of a command's completion besides.
constexpr std::uint64_t kBytesOfTransaction = 256, kBytesOfCompletion = 768;

}  // namespace

// What stands on the board.
struct Board::Parts {
  Parts(const v1::BoardConfig& board_config, std::uint64_t config_hash, BoardObserver* board_observer,
        const Routines* routines, std::uint64_t max_memory_bytes)
      : config(board_config),
        observer(board_observer),
        pci(agp_rates(config.bus())),
        level(make_level(config, observer != nullptr ? observer->observer() : nullptr)),
        commands(config, registers, *level),
        timeline(BusTiming(config.bus()), config.dsp().clock_khz()) {
    commands.set_routines(routines);
    commands.set_max_memory(max_memory_bytes);
    if (observer != nullptr) {
      observer->power_up(config);
      if (auto pixel = observer->explained_pixel()) commands.set_explained(std::move(*pixel));
      timeline.set_watcher(observer);
    }
    registers.set_fixed(reg::kId, wire::kIdValue);
    registers.set_fixed(reg::kFidelity, static_cast<std::uint32_t>(config.fidelity()));
    registers.set_fixed(reg::kProcessors, config.asic().processors());
    registers.set_fixed(reg::kBlockVoxels, config.asic().block_voxels());
    registers.set_fixed(reg::kMaxVolumeVoxels, config.asic().max_volume_voxels());
    registers.set_fixed(reg::kQueueRays, config.asic().queue_rays());
    registers.set_fixed(reg::kCoreKhz, config.asic().core_khz());
    registers.set_fixed(reg::kDatapath, static_cast<std::uint32_t>(config.asic().datapath()));
    registers.set_fixed(reg::kMaxMemory, commands.max_memory_mib());
    registers.set_fixed(reg::kConfigHashLow, static_cast<std::uint32_t>(config_hash));
    registers.set_fixed(reg::kConfigHashHigh, static_cast<std::uint32_t>(config_hash >> 32));
  }

  Reply transact_word(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  Reply read_memory(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  void write_memory(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  // False, and nothing done, if a command under way has that ticket.
  bool command(const wire::FrameHeader& header, std::span<const std::uint8_t> payload, Progress& work);
  Reply wait(std::span<const std::uint8_t> payload);
  Reply cancel(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  void control(std::uint32_t bits);
  void lack_memory();

  Reply finish(const wire::FrameHeader& header, const BusTransaction& transaction, std::vector<std::uint8_t> payload) {
    const std::uint64_t id = next_transaction++;
    timeline.add(header.time_ps, id, transaction);
    return {.time_ps = timeline.finish(id), .payload = std::move(payload)};
  }
  std::vector<Completion> take_completions();
  std::uint64_t held_bytes() const {
    return result_bytes + under_way.size() * kBytesOfCompletion + timeline.under_way() * kBytesOfTransaction;
  }
  std::vector<wire::Counter> count() const;
  void state(Archive& archive, bool with_level);

  v1::BoardConfig config;
  BoardObserver* observer;  // may be null
  RegisterFile registers;
  PciConfigFile pci;
  std::unique_ptr<Level> level;
  DspCommands commands;
  Timeline timeline;
  std::uint64_t next_transaction = 1;
  std::unordered_map<std::uint64_t, Completion> under_way;   // by transaction
  std::unordered_map<std::uint32_t, std::uint64_t> tickets;  // ticket -> transaction
  std::uint64_t result_bytes = 0;                            // of the payloads in under_way
};

void Board::Parts::control(std::uint32_t bits) {
  if ((bits & wire::kControlReset) != 0) {
    registers.reset();
    commands.reset();
  }
  if ((bits & wire::kControlClearVolume) != 0) commands.clear_volume();
  if ((bits & wire::kControlClearIrradiance) != 0) commands.clear_irradiance();
  if ((bits & wire::kControlClearSums) != 0) commands.clear_sums();
  if ((bits & wire::kControlDropBlocks) != 0) commands.drop_blocks();
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
      switch (commands.accept_register(offset)) {
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
  auto bytes = commands.aperture().read(address, length);
  if (!bytes)
    return refuse(ErrorCode::kBadAddress, fmt::format("no memory of {} bytes at address {}", length, address));
  // The DSP sends the bytes as bus master once the commands before are done.
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
  const Acceptance accepted = commands.write_memory(address, bytes);
  if (accepted == Acceptance::kTaken) return;
  if (accepted == Acceptance::kTooMuchMemory) lack_memory();
  registers.raise(wire::kStatusBadAddress, static_cast<std::uint32_t>(address));
}

// Beside the bit that says which write it was, so that a driver that does not know this one sees that it was refused.
void Board::Parts::lack_memory() {
  registers.set_fixed(reg::kMemoryAsked, commands.memory_asked_mib());
  registers.raise(wire::kStatusNoMemory, 0);
}

bool Board::Parts::command(const wire::FrameHeader& header, std::span<const std::uint8_t> payload, Progress& work) {
  if (tickets.contains(header.id)) {
    registers.raise(wire::kStatusBadCommand, 0);
    return false;
  }
  if (observer != nullptr && observer->places_cycles()) {
    observer->begin_command(timeline.turn_of(header.time_ps, {.down_bytes = payload.size()}));
  }
  CommandResult result = commands.run(payload, work);
  if (observer != nullptr) observer->end_command();
  if (observer != nullptr && observer->wants_counters()) observer->counted(count());
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
  return true;
}

Reply Board::Parts::wait(std::span<const std::uint8_t> payload) {
  if (payload.size() != 4 && payload.size() != 12) {
    return refuse_payload("a ticket, or a ticket and a deadline", payload);
  }
  const auto ticket = wire::load<std::uint32_t>(payload, 0);
  const Picoseconds deadline = payload.size() == 12 ? wire::load<std::uint64_t>(payload, 4) : kNever;
  const auto found = tickets.find(ticket);
  if (found == tickets.end()) return refuse(ErrorCode::kBadValue, fmt::format("ticket {} is not under way", ticket));
  if (const auto time = timeline.finish(found->second, std::max(deadline, timeline.now()))) return {.time_ps = *time};
  Reply late = refuse(ErrorCode::kDeadline, fmt::format("ticket {} has not completed at {} ps", ticket, deadline));
  late.time_ps = timeline.now();
  return late;
}

// A processor's access, as a register's; the DSP looks through its list meanwhile.
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

void Board::Parts::state(Archive& archive, bool with_level) {
  archive("registers", registers);
  archive("pci", pci);
  archive("commands", commands);
  archive("timeline", timeline);
  archive("next_transaction", next_transaction);
  archive.expect(!timeline.has_from(next_transaction), "next_transaction", "a number that none has", next_transaction);
  std::vector<std::uint64_t> ids;  // of commands
  for (const auto& [id, completion] : under_way) ids.push_back(id);
  std::ranges::sort(ids);
  archive.list("under_way", ids);
  for (const std::uint64_t id : ids) {
    Completion& completion = under_way[id];
    archive.within("command" + std::to_string(id), [&] {
      archive("ticket", completion.ticket);
      archive.at_most("error", completion.error, ErrorCode::kForbidden);
      archive("can_be_cancelled", completion.can_be_cancelled);
      archive.bytes("payload", completion.payload, 0, ~std::uint64_t{0});
      if (!archive.loads()) return;
      archive.expect(timeline.has_watched(id) && id < next_transaction, "ticket", "a command that is under way",
                     completion.ticket);
      archive.expect(tickets.emplace(completion.ticket, id).second, "ticket", "each once", completion.ticket);
      result_bytes += completion.payload.capacity();
    });
  }
  if (with_level) {
    archive.within("level", [&] { level->state(archive, commands.aperture().volume().blocks()); });
  }
}

std::vector<wire::Counter> Board::Parts::count() const {
  std::vector<wire::Counter> list;
  for (const BusDirection direction : {BusDirection::kDown, BusDirection::kUp}) {
    const BusCounters& bus = timeline.bus().counters(direction);
    const std::string prefix = direction == BusDirection::kDown ? "bus.down." : "bus.up.";
    list.push_back({prefix + "bytes", "byte", bus.bytes});
    list.push_back({prefix + "transfers", "transfer", bus.transfers});
    list.push_back({prefix + "bursts", "burst", bus.bursts});
    list.push_back({prefix + "busy_ps", "ps", bus.busy_ps});
    list.push_back({prefix + "wait_ps", "ps", bus.wait_ps});
  }
  for (std::size_t i = 0; i < kCargoNames.size(); ++i) {
    const CargoCounters& cargo = timeline.bus().counters(static_cast<Cargo>(i));
    const std::string prefix = std::string("bus.") + kCargoNames[i] + '.';
    list.push_back({prefix + "bytes", "byte", cargo.bytes});
    list.push_back({prefix + "transfers", "transfer", cargo.transfers});
    list.push_back({prefix + "time_ps", "ps", cargo.time_ps});
  }
  list.push_back({"dsp.busy_ps", "ps", timeline.dsp_busy_ps()});
  list.push_back({"dsp.host_bus_wait_ps", "ps", timeline.host_bus_wait_ps()});
  commands.count(list);
  return list;
}

Board::Board(const v1::BoardConfig& config, std::uint64_t config_hash, BoardObserver* observer,
             const Routines* routines, std::uint64_t max_memory_bytes)
    : parts_(std::make_unique<Parts>(config, config_hash, observer,
                                     routines != nullptr ? routines : &built_in_routines(), max_memory_bytes)) {
  publish(false);
}

Board::~Board() = default;

const v1::BoardConfig& Board::config() const { return parts_->config; }

void Board::state(Archive& archive, bool with_level) {
  if (archive.loads() && parts_->next_transaction != 1) {
    throw std::logic_error("checkpoint: expected a board on which nothing was done");
  }
  parts_->state(archive, with_level);
  if (archive.loads()) publish(false);
}

void Board::set_minor_version(std::uint16_t minor) { parts_->commands.set_minor_version(minor); }

void Board::add_memory_error(const MemoryError& error) { parts_->commands.add_memory_error(error); }

std::uint64_t Board::held_bytes() const { return parts_->held_bytes(); }

TransactionResult Board::transact(const wire::FrameHeader& header, std::span<const std::uint8_t> payload,
                                  Progress& work) {
  TransactionResult outcome;
  if (header.time_ps > kEndOfTime) {
    parts_->registers.raise(wire::kStatusBadCommand, 0);
    outcome.reply = refuse(ErrorCode::kBadValue, fmt::format("time_ps: expected at most 2^62, got {}", header.time_ps));
    outcome.reply->time_ps = parts_->timeline.now();
    if (posted(header.type)) outcome.reply.reset();
    return outcome;
  }
  switch (header.type) {
    case FrameType::kConfigRead:
    case FrameType::kConfigWrite:
    case FrameType::kRegisterRead: outcome.reply = parts_->transact_word(header, payload); break;
    case FrameType::kRegisterWrite: parts_->transact_word(header, payload); return outcome;
    case FrameType::kMemoryWrite: parts_->write_memory(header, payload); return outcome;
    case FrameType::kMemoryRead: outcome.reply = parts_->read_memory(header, payload); break;
    case FrameType::kCommand: {
      work.may_count = [this] { publish_if_asked(); };
      const Finally no_more{[&work] { work.may_count = nullptr; }};
      outcome.ticket_in_use = !parts_->command(header, payload, work);
      break;
    }
    case FrameType::kWait: outcome.reply = parts_->wait(payload); break;
    case FrameType::kCancel: outcome.reply = parts_->cancel(header, payload); break;
    case FrameType::kPoll:
    case FrameType::kCounters: {
      parts_->timeline.advance(header.time_ps);
      outcome.reply = Reply{.time_ps = header.time_ps};
      if (header.type == FrameType::kCounters) outcome.reply->payload = wire::encode(parts_->count());
      break;
    }
    default: outcome.reply = refuse(ErrorCode::kUnsupported, "no such transaction"); break;
  }
  if (outcome.reply) {
    outcome.completions = parts_->take_completions();
    const bool passed = outcome.reply->error == ErrorCode::kDeadline;
    if (outcome.reply->error != ErrorCode::kNone && !passed) outcome.reply->time_ps = header.time_ps;
    if (parts_->observer != nullptr) {
      parts_->observer->host_waited(wait_name(header.type), header.time_ps, outcome.reply->time_ps);
    }
  }
  publish(is_asked_.exchange(false) || is_watched_);
  is_watched_ = false;
  return outcome;
}

void Board::publish(bool with_machine) {
  auto counters = parts_->count();
  MachineLook machine;
  if (with_machine) machine = parts_->commands.look();
  const std::lock_guard lock(published_mutex_);
  published_.simulated_ps = parts_->timeline.now();
  published_.counters = std::move(counters);
  if (with_machine) published_.machine = std::move(machine);
  published_memory_ = parts_->commands.limited_memory();
}

}  // namespace gicube::emu
