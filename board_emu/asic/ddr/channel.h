// The controller of one channel of DDR SDRAM: serves packets in the order in which they are asked for, with open pages.
//
// As the RDRAM's it keeps no queue: a call places all commands of its packet at once, each at its earliest legal clock, and
// says when the data come; so the caller's queue depth is the look-ahead. All commands share one command bus, one a clock.
// RD and WR keep the order of requests, so do ACT with REF, and PRE; but a command may take a free clock before one of
// another kind that is already placed. A bank stays open until another row of it is needed or its rank is refreshed. Each
// rank has one REF every refresh_interval, for which all its banks are precharged; the ranks are spread evenly over the
// interval; requests at hand go first, by no more than the caller's queue.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "asic/ddr/data_wires.h"
#include "asic/ddr/rank.h"
#include "asic/ddr/timing.h"
#include "asic/dram/access.h"
#include "asic/dram/gap_wires.h"

namespace gicube::emu::ddr {

using dram::Access;
using dram::ChannelCounters;
using dram::Delay;
using dram::IssuedCommand;
using dram::Location;

class Channel {
 public:
  // `ranks` from 1 on. Throws std::invalid_argument for 0.
  Channel(const v1::DdrConfig& config, std::uint32_t ranks);

  // The packet at `at`, asked for at `arrival`, which never decreases from call to call (reads and writes together).
  Access read(const Location& at, Tcycle arrival) { return serve(Command::kRead, at, arrival); }
  Access write(const Location& at, Tcycle arrival) { return serve(Command::kWrite, at, arrival); }
  // Carries out the refreshes that were due by `t`; no packet may arrive before it afterwards.
  void advance(Tcycle t) {
    while (refresh_due_ <= t) refresh_next();
  }

  // Until `t` no packet would be delayed by one that was asked for before.
  bool idle(Tcycle t) const { return dq_free_ <= t; }
  ChannelCounters counters() const;
  void describe(std::ostream& out) const;  // for a stall report
  // Every command from now on is appended, in the order of placing; null stops it.
  void set_trace(std::vector<IssuedCommand>* sink) { trace_ = sink; }

 private:
  Access serve(Command command, const Location& at, Tcycle arrival);
  Delay open(const Location& at, Tcycle arrival);
  // At `floor` or as soon as the command bus is free.
  Tcycle place(Command command, const Location& at, Tcycle floor, Tcycle asked);
  void precharge(const Location& at, Tcycle asked);
  Tcycle activate(Command command, const Location& at, Tcycle asked);
  void refresh_next();

  std::vector<Rank> ranks_;
  std::vector<Tcycle> refreshed_until_;  // by rank: its first clock for an ACT after the last REF
  dram::GapWires<1> command_bus_;
  DataWires data_wires_;
  Tcycle last_open_ = 0;  // ACT or REF
  Tcycle last_precharge_ = 0;
  Tcycle dq_free_ = 0;
  bool last_was_write_ = false;

  std::uint64_t refresh_interval_;
  std::uint32_t refresh_time_;       // tRFC
  std::uint64_t refresh_count_ = 0;  // also tells the rank of the next
  Tcycle refresh_due_ = kNever;

  std::uint64_t reads_ = 0, writes_ = 0, misses_ = 0, conflicts_ = 0, precharges_ = 0, turnaround_ = 0;
  std::vector<IssuedCommand>* trace_ = nullptr;
};

}  // namespace gicube::emu::ddr
