// The controller of one channel: serves packets in the order in which they are asked for, with open pages.
//
// It keeps no queue. A call places all commands of its packet at once, each at its earliest legal tCYCLE, and says when the
// data come; so the caller's queue depth is the look-ahead. RD and WR keep the order of requests, so do ACT (with REFA),
// and PRE; but a PRE may come before the ACT, and an ACT before the RD, of an earlier request. While precharges queue for
// the wires, an ACT leaves the place of the next PRE free: that is the one case of a command later than it could be. A bank stays open until
// another row of it or a neighbour is needed. Each device has one REFA every refresh_interval, to its banks in turn, the
// devices spread evenly over the interval; requests at hand go first, by no more than the caller's queue.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <vector>

#include "asic/dram/access.h"
#include "asic/rdram/device.h"
#include "asic/rdram/timing.h"
#include "asic/rdram/wires.h"

namespace gicube::emu::rdram {

using dram::Access;
using dram::ChannelCounters;
using dram::Delay;
using dram::IssuedCommand;
using dram::Location;

class Channel {
 public:
  // `devices` from 1 on. Throws std::invalid_argument for 0.
  Channel(const v1::RdramConfig& config, std::uint32_t devices);

  // The packet at `at`, asked for at `arrival`, which never decreases from call to call (reads and writes together).
  Access read(const Location& at, Tcycle arrival) { return serve<Command::kRead>(at, arrival); }
  Access write(const Location& at, Tcycle arrival) { return serve<Command::kWrite>(at, arrival); }
  // Carries out the refreshes that were due by `t`; no packet may arrive before it afterwards.
  void advance(Tcycle t) {
    if (t >= next_event_) [[unlikely]]
      run_refresh(t);
  }

  // Until `t` no packet would be delayed by one that was asked for before.
  bool idle(Tcycle t) const { return dq_free_ <= t; }
  ChannelCounters counters() const;
  void describe(std::ostream& out) const;  // for a stall report
  // Every command from now on is appended, in the order of placing; null stops it.
  void set_trace(std::vector<IssuedCommand>* sink) { trace_ = sink; }

 private:
  struct Closing {
    bool pending = false;  // a refreshed bank is still open
    std::uint16_t device = 0;
    int bank = 0;
    Tcycle due = 0;
  };

  template <Command kCommand>
  Access serve(const Location& at, Tcycle arrival);
  Delay open(const Location& at, Tcycle arrival);
  // True if it had to wait for the wires or the device, not for its bank.
  bool precharge(std::uint16_t device, int bank, Tcycle asked);
  // With `leave_gap` it goes after the place of the next precharge.
  template <Command kOpens>
  Tcycle activate(const Location& at, Tcycle asked, bool leave_gap);
  bool held_by_refresh(const Location& at, Tcycle arrival) const;
  void run_refresh(Tcycle now);
  void refresh_next();
  void close_refreshed();
  void record(Command command, bool tight, const Location& at, Tcycle begin, Tcycle asked) const;

  std::vector<Device> devices_;
  RowWires row_wires_;
  ColumnWires column_wires_;
  Tcycle last_open_ = 0;  // ACT or REFA
  Tcycle last_precharge_ = 0;
  Tcycle dq_free_ = 0;
  bool last_was_write_ = false;
  bool last_open_was_refresh_ = false;

  std::uint64_t refresh_interval_;
  std::uint64_t refresh_count_ = 0;  // also tells device and bank of the next
  std::uint32_t precharge_gap_;      // tPP
  std::uint32_t recovery_;           // tRC after REFA
  std::uint32_t refresh_gap_;        // tRR after REFA
  std::uint32_t refreshed_open_;     // tRAS after REFA
  Tcycle refresh_due_ = kNever;
  Tcycle next_event_ = kNever;
  Closing closing_;
  Location refreshed_{};  // the bank refreshed last, and when it can be activated again
  Tcycle refreshed_until_ = 0;

  std::uint64_t reads_ = 0, writes_ = 0, misses_ = 0, conflicts_ = 0, precharges_ = 0, turnaround_ = 0;
  std::vector<IssuedCommand>* trace_ = nullptr;
};

// Inline: the memory model is asked for every packet of a simulated frame.
template <Command kCommand>
inline Access Channel::serve(const Location& at, Tcycle arrival) {
  advance(arrival);
  constexpr bool kWrite = kCommand == Command::kWrite;
  Device& device = devices_[at.device];
  Delay row_delay = Delay::kTransfer;
  if (device.open_row(at.bank) != at.row) row_delay = open(at, arrival);
  const Tcycle bank_ready = std::max(arrival, device.bank_ready<kCommand>(at.bank));
  const Tcycle wires_ready = std::max(device.device_ready<kCommand>(), column_wires_.probe<kCommand>(arrival));
  const Tcycle begin = std::max(bank_ready, wires_ready);
  Access access;
  access.data_begin = column_wires_.data<kCommand>(begin);
  access.data_end = access.data_begin + kPacket;
  if (bank_ready > wires_ready) access.cause = row_delay;
  if (kWrite != last_was_write_) {
    const Tcycle without = std::max(dq_free_, column_wires_.data<kCommand>(bank_ready));
    turnaround_ += access.data_begin - without;
    last_was_write_ = kWrite;
  }
  column_wires_.reserve<kCommand>(begin);
  device.issue<kCommand>(at.bank, at.row, begin);
  dq_free_ = access.data_end;
  ++(kWrite ? writes_ : reads_);
  record(kCommand, true, at, begin, arrival);
  return access;
}

inline void Channel::record(Command command, bool tight, const Location& at, Tcycle begin, Tcycle asked) const {
  if (trace_ == nullptr) [[likely]]
    return;
  trace_->push_back({command, tight, at.device, at.row, at.bank, at.column, begin, asked});
}

}  // namespace gicube::emu::rdram
