// Simulated time of the functional level: host bus and DSP, with an ASIC that takes none.
//
// An errand goes down the bus, through the DSP, and up the bus. The DSP serves errands in the order of their arrival.
// Time advances only as far as it can no longer change: nothing older than the host's latest stamp will follow.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "bus/host_bus.h"
#include "gicube/v1/board_config.pb.h"
#include "sim/clock.h"

namespace gicube::emu {

struct Errand {
  TransferKind kind = TransferKind::kBulk;
  Cargo cargo = Cargo::kRegister;
  std::uint64_t down_bytes = 0;
  bool dsp = false;  // waits for its turn at the DSP, even with no cycles of its own
  std::uint64_t dsp_cycles = 0;
  std::uint64_t up_bytes = 0;
  Cargo up_cargo = Cargo::kCompletion;
  bool watched = false;  // somebody wants to know when it has finished
};

struct Finished {
  std::uint64_t id = 0;
  Picoseconds time_ps = 0;
};

class Timeline {
 public:
  Timeline(const BusTiming& bus, std::uint64_t dsp_khz) : bus_(bus), dsp_khz_(dsp_khz) {}

  // The host issues an errand at `stamp` and names it `id` (unique). First advances to `stamp`.
  void add(Picoseconds stamp, std::uint64_t id, const Errand& errand);

  // Lets time pass up to `horizon`.
  void advance(Picoseconds horizon);

  // Lets time pass until that watched errand is finished, and returns when. It must not have been taken yet.
  Picoseconds finish(std::uint64_t id);

  // The watched errands that have finished by now and were not taken yet, in the order of their time.
  std::vector<Finished> take_finished();

  Picoseconds now() const { return now_ps_; }
  Picoseconds dsp_busy_ps() const { return dsp_busy_ps_; }
  const HostBus& bus() const { return bus_; }

 private:
  void deliver(const BusDelivery& delivery);
  void end(std::uint64_t id, Picoseconds time);

  HostBus bus_;
  std::uint64_t dsp_khz_;
  Picoseconds now_ps_ = 0;
  Picoseconds dsp_free_ps_ = 0;
  Picoseconds dsp_busy_ps_ = 0;
  std::unordered_map<std::uint64_t, Errand> under_way_;
  std::vector<Finished> finished_;  // some may lie in the future: the DSP's work is known as soon as it begins
};

}  // namespace gicube::emu
