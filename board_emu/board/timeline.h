// Simulated time of the functional level: host bus and DSP, with an ASIC that takes none.
//
// A transaction goes down the bus, through the DSP, and up the bus. The DSP serves transactions in the order of their arrival.
// Time advances only as far as it can no longer change: nothing older than the host's latest stamp will follow. A transaction
// can be taken back until its turn at the DSP begins.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <unordered_map>
#include <vector>

#include "board/bus/host_bus.h"
#include "gicube/v1/board_config.pb.h"
#include "words/clock.h"

namespace gicube::emu {

struct BusTransaction {
  TransferKind kind = TransferKind::kBulk;
  Cargo cargo = Cargo::kRegister;
  std::uint64_t down_bytes = 0;
  bool dsp = false;              // waits for its turn at the DSP, even with no cycles of its own
  std::uint64_t dsp_cycles = 0;  // in which the DSP is busy
  Picoseconds asic_ps = 0;       // the turn lasts at least as long, since the ASIC works
  std::uint64_t up_bytes = 0;
  Cargo up_cargo = Cargo::kCompletion;
  bool watched = false;   // somebody wants to know when it has finished
  const char* name = "";  // of its turn at the DSP, in a trace
};

struct Finished {
  std::uint64_t id = 0;
  Picoseconds time_ps = 0;
};

// Hears of everything as soon as it can no longer change.
class TimelineWatcher {
 public:
  virtual ~TimelineWatcher() = default;
  // In the order of their ends.
  virtual void transferred(const BusDelivery& delivery) = 0;
  // A turn at the DSP; in the order of their begins.
  virtual void served(const BusTransaction& transaction, Picoseconds begin, Picoseconds end) = 0;
};

class Timeline {
 public:
  Timeline(const BusTiming& bus, std::uint64_t dsp_khz) : bus_(bus), dsp_khz_(dsp_khz) {}

  // The host issues a transaction at `stamp` and names it `id` (unique). First advances to `stamp`.
  void add(Picoseconds stamp, std::uint64_t id, const BusTransaction& transaction);

  // When the turn at the DSP of a transaction like this will begin if it is added at `stamp`. No later transaction can change it:
  // they all follow on the way down. (That one before it is taken back can.)
  Picoseconds turn_of(Picoseconds stamp, const BusTransaction& transaction) const;

  // Null for none.
  void set_watcher(TimelineWatcher* watcher) { watcher_ = watcher; }

  // Lets time pass up to `horizon`.
  void advance(Picoseconds horizon);

  // Lets time pass until that watched transaction is finished, and returns when; but no longer than to `deadline`, and then
  // nothing. It must not have been taken yet.
  std::optional<Picoseconds> finish(std::uint64_t id, Picoseconds deadline);
  Picoseconds finish(std::uint64_t id) { return *finish(id, kNever); }

  // Takes a transaction back at `stamp`: it costs the DSP nothing, and no more than a completion word goes up. False if its
  // turn has begun.
  bool take_back(Picoseconds stamp, std::uint64_t id);

  // The watched transactions that have finished by now and were not taken yet, in the order of their time.
  std::vector<Finished> take_finished();

  Picoseconds now() const { return now_ps_; }
  Picoseconds dsp_busy_ps() const { return dsp_busy_ps_; }
  // Time in which the DSP had nothing to do while a command for it was on its way down the bus.
  Picoseconds host_bus_wait_ps() const { return host_bus_wait_ps_; }
  const HostBus& bus() const { return bus_; }

 private:
  // Everything but advance() and take_back() counts on no turn being over that has not been ended.
  bool step(Picoseconds horizon);
  void deliver(const BusDelivery& delivery);
  void begin_turns();
  void end_turn();
  void send_up(std::uint64_t id, Picoseconds ready);
  void end(std::uint64_t id, Picoseconds time);

  HostBus bus_;
  std::uint64_t dsp_khz_;
  TimelineWatcher* watcher_ = nullptr;
  Picoseconds now_ps_ = 0;
  Picoseconds dsp_free_ps_ = 0;
  Picoseconds dsp_busy_ps_ = 0;
  Picoseconds host_bus_wait_ps_ = 0;
  struct Issued {
    BusTransaction transaction;
    Picoseconds stamp_ps = 0;
  };
  struct Arrived {
    std::uint64_t id = 0;
    Picoseconds time_ps = 0;
  };
  std::unordered_map<std::uint64_t, Issued> under_way_;
  std::deque<Arrived> dsp_queue_;         // those that wait for their turns
  std::optional<std::uint64_t> in_turn_;  // the transaction at the DSP, until dsp_free_ps_
  std::vector<Finished> finished_;
};

}  // namespace gicube::emu
