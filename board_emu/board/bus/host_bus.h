// The host bus: one half-duplex bus, two ordered directions, burst by burst.
//
// What enters: transfers, each with the time at which its first byte is ready. What leaves: their times of delivery.
// Arbitration is hidden; when both directions ask they take turns, and a running burst ends at the latency timer or
// when the other begins to ask, whichever is later [C, docs/reference/hardware.md].
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>

#include "board/bus/bus_timing.h"
#include "words/clock.h"

namespace gicube::emu {

// What a transfer carries: its time is counted by this.
enum class Cargo : std::uint8_t { kRegister, kTable, kVolume, kCommand, kRays, kImage, kCompletion };
inline constexpr std::array<const char*, 7> kCargoNames{"register", "table", "volume",    "command",
                                                        "rays",     "image", "completion"};

struct BusTransfer {
  std::uint64_t id = 0;
  TransferKind kind = TransferKind::kBulk;
  Cargo cargo = Cargo::kRegister;
  std::uint64_t bytes = 0;  // 0 takes no time, but keeps its place in its direction
  Picoseconds ready_ps = 0;
};

struct BusDelivery {
  std::uint64_t id = 0;
  Direction direction = Direction::kDown;
  Picoseconds time_ps = 0;
  Picoseconds begin_ps = 0;  // of its first burst; no earlier than the delivery before it in its direction
  Cargo cargo = Cargo::kRegister;
  std::uint64_t bytes = 0;
};

struct BusCounters {
  std::uint64_t bytes = 0;
  std::uint64_t transfers = 0;
  std::uint64_t bursts = 0;
  Picoseconds busy_ps = 0;
  Picoseconds wait_ps = 0;  // ready transfers at the head of their direction that had to wait for the bus
};

// Of one cargo, both directions.
struct CargoCounters {
  std::uint64_t bytes = 0;
  std::uint64_t transfers = 0;
  Picoseconds time_ps =
      0;  // each transfer from its turn in its direction to its delivery: what it waited and what it took
};

class HostBus {
 public:
  explicit HostBus(const BusTiming& timing) : timing_(timing) {}

  // Whether a transfer waits or is under way.
  bool carries(Direction direction, std::uint64_t id) const;

  // Within one direction transfers are served in this order, whatever their ready times.
  void enqueue(Direction direction, const BusTransfer& transfer);

  // Runs until the next delivery not later than `horizon`, and returns it; nothing if there is none. Only bursts that end
  // by `horizon` are decided, so a transfer enqueued later with ready_ps >= horizon still meets the bus as it would have.
  std::optional<BusDelivery> next_delivery(Picoseconds horizon);

  const BusCounters& counters(Direction direction) const { return side(direction).counters; }
  const CargoCounters& counters(Cargo cargo) const { return cargoes_[static_cast<std::size_t>(cargo)]; }

 private:
  struct Side {
    std::deque<BusTransfer> queue;
    std::uint64_t dwords_left = 0;  // of the head
    bool head_started = false;
    Picoseconds head_begin_ps = 0;
    Picoseconds last_delivery_ps = 0;  // also when the head's turn began, if it was ready by then
    BusCounters counters;
  };

  Side& side(Direction direction) { return sides_[static_cast<std::size_t>(direction)]; }
  const Side& side(Direction direction) const { return sides_[static_cast<std::size_t>(direction)]; }
  // When the head of a direction could take the bus; kNever without one.
  Picoseconds head_ready(Direction direction) const;
  std::uint64_t bursts_alone(Direction direction, Picoseconds start, Picoseconds limit) const;

  BusTiming timing_;
  std::array<Side, 2> sides_;
  std::array<CargoCounters, kCargoNames.size()> cargoes_;
  Picoseconds free_ps_ = 0;
  Direction last_ = Direction::kUp;
};

}  // namespace gicube::emu
