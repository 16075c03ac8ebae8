// The host bus: one half-duplex bus with two ordered directions, simulated burst by burst.
//
// Input: transfers, each with the time at which its first byte is ready. Output: delivery times. Arbitration is hidden.
// When both directions request the bus, they take turns. A running burst ends at the latency timer or when the other
// direction requests the bus, whichever is later [C, H1101-H1110].
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "gicube/archive.h"
#include "gicube/v1/board_config.pb.h"
#include "words/clock.h"

namespace gicube::emu {

enum class BusDirection : std::uint8_t { kDown, kUp };  // to the board, to the host

enum class TransferKind : std::uint8_t {
  kBulk,           // memory writes and commands down, results and images up
  kRegisterWrite,  // write of a few dwords by a processor
  kRegisterRead,   // round trip of a processor's read
};

inline constexpr std::uint32_t kPciOverheadClocks = 3;
inline constexpr std::uint32_t kAgpRequestDwords = 64;
inline constexpr std::uint32_t kAgpRequestOverheadClocks = 2;  // chosen: gives 50-80% of peak on short reads
inline constexpr Picoseconds kPciClockPs = 30'000;             // 33 1/3 MHz
inline constexpr Picoseconds kAgpClockPs = 15'000;             // 66 2/3 MHz

// Duration of one burst of dwords, in closed form.
//
// PCI, 33 1/3 MHz, 32 bit: a write burst of n dwords takes n + 3 clocks, a read n + 3 + L (address, turnaround, target
// latency). A burst has at most `max_burst_dwords`, and at most `latency_timer_clocks` after another request. AGP: the
// card reads host memory in pipelined requests of up to 64 dwords (256 bytes, AGP 2.0's long read). Each takes ceil(n /
// rate) + 2 clocks of 66 2/3 MHz: on 2x this is half the peak at 16 bytes and 80% at 64 bytes. Writes to the host and
// register accesses run as PCI transfers at the AGP clock (docs/reference/hardware.md, host bus).
struct BusTiming {
  Picoseconds clock_ps = kPciClockPs;
  std::uint32_t agp_rate = 0;  // dwords per clock of an AGP read: 1, 2, 4; 0 on PCI
  std::uint32_t max_burst_dwords;
  std::uint32_t latency_timer_clocks;
  std::uint32_t read_latency_clocks;

  explicit BusTiming(const v1::BusConfig& config)
      : max_burst_dwords(config.max_burst_dwords()),
        latency_timer_clocks(config.latency_timer_clocks()),
        read_latency_clocks(config.read_latency_clocks()) {
    switch (config.model()) {
      case v1::agp1x: agp_rate = 1; break;
      case v1::agp2x: agp_rate = 2; break;
      case v1::agp4x: agp_rate = 4; break;
      default: break;
    }
    if (agp_rate != 0) clock_ps = kAgpClockPs;
  }

  bool agp_read(BusDirection direction, TransferKind kind) const {
    return agp_rate != 0 && direction == BusDirection::kDown && kind == TransferKind::kBulk;
  }

  // The longest burst of that kind without contention.
  std::uint32_t longest_burst(BusDirection direction, TransferKind kind) const {
    return agp_read(direction, kind) ? std::min(kAgpRequestDwords, max_burst_dwords) : max_burst_dwords;
  }

  std::uint32_t burst_clocks(BusDirection direction, TransferKind kind, std::uint32_t dwords) const {
    if (agp_read(direction, kind)) return (dwords + agp_rate - 1) / agp_rate + kAgpRequestOverheadClocks;
    const std::uint32_t latency = kind == TransferKind::kRegisterRead ? read_latency_clocks : 0;
    return dwords + kPciOverheadClocks + latency;
  }

  // Number of dwords in a burst of at most `clocks`; at least one, because a granted burst transfers something.
  std::uint32_t dwords_within(BusDirection direction, TransferKind kind, std::uint64_t clocks) const {
    const std::uint64_t overhead = burst_clocks(direction, kind, 1) - 1;
    const std::uint64_t data_clocks = clocks > overhead ? clocks - overhead : 1;
    const std::uint64_t dwords = agp_read(direction, kind) ? data_clocks * agp_rate : data_clocks;
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(dwords, longest_burst(direction, kind)));
  }
};

// Contents of a transfer, for which its time is counted.
enum class Cargo : std::uint8_t { kRegister, kTable, kVolume, kCommand, kRays, kImage, kCompletion };
inline constexpr std::array<const char*, 7> kCargoNames{"register", "table", "volume",    "command",
                                                        "rays",     "image", "completion"};

// Limits of a checkpoint. chosen: far above real values, and low enough for sums not to overflow and for the bus to
// transfer the bytes in progress within seconds, burst by burst.
inline constexpr Picoseconds kMostTime = Picoseconds{1} << 62, kMostSpan = Picoseconds{1} << 60;
inline constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 36;

struct BusTransfer {
  std::uint64_t id = 0;
  TransferKind kind = TransferKind::kBulk;
  Cargo cargo = Cargo::kRegister;
  std::uint64_t bytes = 0;  // 0 takes no time, but keeps its position in its direction
  Picoseconds ready_ps = 0;

  void state(Archive::Record& record) {
    record(id);
    record.at_most(kind, TransferKind::kRegisterRead);
    record.at_most(cargo, Cargo::kCompletion);
    record.at_most(bytes, kMostBytes);
    record.at_most(ready_ps, kMostTime);
  }
};

struct BusDelivery {
  std::uint64_t id = 0;
  BusDirection direction = BusDirection::kDown;
  Picoseconds time_ps = 0;
  Picoseconds begin_ps = 0;  // of its first burst; not before the previous delivery in its direction
  Cargo cargo = Cargo::kRegister;
  std::uint64_t bytes = 0;
};

struct BusCounters {
  std::uint64_t bytes = 0;
  std::uint64_t transfers = 0;
  std::uint64_t bursts = 0;
  Picoseconds busy_ps = 0;
  Picoseconds wait_ps = 0;  // time that ready transfers at the head of their direction waited for the bus

  void state(Archive::Record& record) { record(bytes, transfers, bursts, busy_ps, wait_ps); }
};

// Counters of one cargo in both directions.
struct CargoCounters {
  std::uint64_t bytes = 0;
  std::uint64_t transfers = 0;
  Picoseconds time_ps = 0;  // from a transfer's turn in its direction to its delivery: waiting and transfer

  void state(Archive::Record& record) { record(bytes, transfers, time_ps); }
};

class HostBus {
 public:
  explicit HostBus(const BusTiming& timing) : timing_(timing) {}

  // The ids of all transfers, in any order.
  std::vector<std::uint64_t> transfers() const {
    std::vector<std::uint64_t> ids;
    for (const Side& side : sides_) {
      for (const BusTransfer& transfer : side.queue) ids.push_back(transfer.id);
    }
    return ids;
  }
  bool carries(BusDirection direction, std::uint64_t id) const {
    const auto& queue = side(direction).queue;
    return std::any_of(queue.begin(), queue.end(), [id](const BusTransfer& transfer) { return transfer.id == id; });
  }

  // Within one direction, transfers are served in the order of these calls, regardless of their ready times.
  void enqueue(BusDirection direction, const BusTransfer& transfer);

  // Advances to the next delivery not later than `horizon` and returns it; nothing if there is none. Only bursts that
  // end by `horizon` are decided, so the result does not depend on whether a transfer with ready_ps >= horizon is
  // enqueued before or after.
  std::optional<BusDelivery> next_delivery(Picoseconds horizon);

  const BusCounters& counters(BusDirection direction) const { return side(direction).counters; }
  const CargoCounters& counters(Cargo cargo) const { return cargoes_[static_cast<std::size_t>(cargo)]; }
  void state(Archive& archive) {
    archive.parts("direction", sides_);
    archive("cargoes", cargoes_);
    archive.at_most("free", free_ps_, kMostTime);
    archive.at_most("last", last_, BusDirection::kUp);
  }

 private:
  struct Side {
    std::deque<BusTransfer> queue;
    std::uint64_t dwords_left = 0;  // of the head
    bool head_started = false;
    Picoseconds head_begin_ps = 0;
    Picoseconds last_delivery_ps = 0;  // also the begin of the head's turn, if it was ready by then
    BusCounters counters;

    void state(Archive& archive) {
      archive.list("queue", queue);
      archive.field("head", [this](Archive::Record& record) {
        record.at_most(dwords_left, kMostBytes);
        record(head_started);
        record.at_most(head_begin_ps, kMostTime);
        record.at_most(last_delivery_ps, kMostTime);
      });
      archive("counters", counters);
    }
  };

  Side& side(BusDirection direction) { return sides_[static_cast<std::size_t>(direction)]; }
  const Side& side(BusDirection direction) const { return sides_[static_cast<std::size_t>(direction)]; }
  // Earliest time at which the head of a direction can use the bus; kNever if it is empty.
  Picoseconds head_ready(BusDirection direction) const {
    const Side& from = side(direction);
    return from.queue.empty() ? kNever : from.queue.front().ready_ps;
  }
  std::uint64_t bursts_alone(BusDirection direction, Picoseconds start, Picoseconds limit) const;

  BusTiming timing_;
  std::array<Side, 2> sides_;
  std::array<CargoCounters, kCargoNames.size()> cargoes_;
  Picoseconds free_ps_ = 0;
  BusDirection last_ = BusDirection::kUp;
};

}  // namespace gicube::emu
