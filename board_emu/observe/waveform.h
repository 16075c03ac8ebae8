// Writes the signals of the board's clocked parts to a value change dump, for a window of core cycles.
//
// The value of a signal in a cycle is the state of its part at the clock edge that ends the cycle, or the part's
// activity in it (cause, active queue, busy). The window is written once, for the first machine whose clock reaches it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "cycle/machine.h"
#include "observe/active_queue.h"
#include "observe/vcd_file.h"

namespace gicube::emu {

class Waveform : public Observer {
 public:
  // Throws std::runtime_error, which names the file.
  Waveform(const std::string& path, const CycleWindow& window) : vcd_(path), window_(window) {}
  ~Waveform() override;

  Waveform(const Waveform&) = delete;
  Waveform& operator=(const Waveform&) = delete;

  // Sets the core clock of all further machines.
  void set_clock(std::uint64_t core_khz) { core_khz_ = core_khz; }
  // Also requests the cycle before the window, which gives the state before it.
  Cycle next(Cycle from) override {
    if (state_ == State::kEnded) return kNoCycle;
    return std::max(from, std::max<Cycle>(window_.begin, 1) - 1);
  }
  void see(Cycle now, const Machine& machine) override {
    if (state_ != State::kEnded) record(now, machine);
  }
  void end_machine() {
    if (state_ != State::kWriting) return;
    vcd_.end(time(next_));
    state_ = State::kEnded;
  }

  const TextFile& file() const { return vcd_.file(); }

 private:
  enum class State : std::uint8_t { kWaiting, kWriting, kEnded };
  void record(Cycle now, const Machine& machine);
  void begin(Cycle now, const Machine& machine);
  // Times are exact if the clock's period is a whole number of picoseconds: the unit is then the coarsest that divides
  // it.
  std::uint64_t time(Cycle cycle) const { return cycles_to_ps(cycle, core_khz_) / unit_ps_; }

  VcdFile vcd_;
  CycleWindow window_;
  State state_ = State::kWaiting;
  std::uint64_t core_khz_ = 1;
  std::uint64_t unit_ps_ = 1;
  Cycle next_ = 0;
  std::uint64_t bus_cycles_ = 0;     // busy cycles of the ray bus so far
  std::vector<ActiveQueue> active_;  // by processor
};

}  // namespace gicube::emu
