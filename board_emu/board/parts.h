// The parts of a board, and the execution of its transactions.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "board/board.h"
#include "board/board_observer.h"
#include "board/timeline.h"
#include "config/energy.h"
#include "config/power_peaks.h"
#include "firmware/commands/card.h"
#include "firmware/register_file.h"

namespace gicube::emu {

// Later timestamps are refused, so that no sum of times can overflow: 2^62 ps are 53 days.
inline constexpr Picoseconds kEndOfTime = Picoseconds{1} << 62;

// chosen: above the size of a transaction's records in the maps and queues, and of a command's completion in addition.
inline constexpr std::uint64_t kBytesOfTransaction = 256, kBytesOfCompletion = 768;

// Makes a reply with an error and its text.
Reply refusal_of(wire::ErrorCode error, const std::string& text);

// The parts of a board.
struct Board::Parts {
  Parts(const v1::BoardConfig& board_config, std::uint64_t config_hash, BoardObserver* board_observer,
        const Routines* routines, std::uint64_t max_memory_bytes);

  Reply transact_word(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  Reply read_memory(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  void write_memory(const wire::FrameHeader& header, std::span<const std::uint8_t> payload);
  // Returns false, and does nothing, if a command in progress has this ticket.
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
  // For the host: with the energy that follows from them.
  std::vector<wire::Counter> count_with_energy() {
    std::vector<wire::Counter> counters = count();
    power.ask(counters);
    energy.count(counters, timeline.now());
    power.count(counters);
    return counters;
  }
  void state(Archive& archive, bool with_level);

  v1::BoardConfig config;
  BoardObserver* observer;  // may be null
  RegisterFile registers;
  PciConfigFile pci;
  std::unique_ptr<Level> level;
  Card card;
  Timeline timeline;
  EnergyModel energy;
  PowerPeaks power{energy, config.asic().core_khz()};
  std::uint64_t next_transaction = 1;
  std::unordered_map<std::uint64_t, Completion> under_way;   // by transaction id
  std::unordered_map<std::uint32_t, std::uint64_t> tickets;  // ticket -> transaction
  std::uint64_t result_bytes = 0;                            // size of the payloads in under_way

  // A command in progress, perhaps from a checkpoint.
  struct Carried {
    wire::FrameHeader header;
    std::span<const std::uint8_t> payload;
    std::vector<std::uint8_t> loaded{};  // storage for a payload from a checkpoint
  };
  std::optional<Carried> carried;
};

}  // namespace gicube::emu
