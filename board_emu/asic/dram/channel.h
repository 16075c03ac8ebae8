// The controller of one channel: serves packets in the order of the requests, with open pages.
//
// It keeps no queue. A call schedules all commands of its packet at once, each at its earliest legal clock, and returns
// the time of the data; the look-ahead is therefore the depth of the caller's queue. RD and WR keep the order of the
// requests, as do ACT together with refreshes, and PRE. A command may take free clocks before a scheduled command of
// another kind. A bank stays open until another row needs it or its sense amps. Pending requests precede a due refresh,
// which delays it by the caller's queue at most.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "asic/dram/device.h"
#include "asic/dram/memory.h"
#include "asic/dram/wires.h"

namespace gicube::emu::dram {

// `Rules`: the standard's rules, those of Device and kName, kDevices, kClock, kCommand (clocks of a command), kPacket
// (clocks of its data), kOneBus (RD and WR share the wires of the other commands), kSwitches (wires.h), kLeavesGaps
// (activate() below). `Derived` implements the standard's refresh: refresh_until() and held_by_refresh().
template <typename Derived, typename Rules>
class Channel {
 public:
  // The packet at `at`, requested at `arrival`, which never decreases from call to call (reads and writes together).
  // Inline, so that the location stays in registers.
  [[gnu::always_inline]] Access read(const Location& at, Tcycle arrival) { return serve<Command::kRead>(at, arrival); }
  Access write(const Location& at, Tcycle arrival) { return serve<Command::kWrite>(at, arrival); }
  // Performs the refreshes that are due by `t`. Later packets may not arrive before `t`.
  void advance(Tcycle t) {
    if (t < next_event_) [[likely]]
      return;
    leave_out(t);
    static_cast<Derived*>(this)->refresh_until(t);
  }

  // Whether a packet that arrives at `t` is not delayed by the data of earlier ones.
  bool idle(Tcycle t) const { return dq_free_ <= t; }
  ChannelCounters counters() const {
    return {.packets_read = reads_,
            .packets_written = writes_,
            .row_hits = reads_ + writes_ - misses_,
            .row_misses = misses_,
            .conflicts = conflicts_,
            .activates = misses_,
            .precharges = precharges_,
            .refreshes = refresh_count_,
            .dq_busy = (reads_ + writes_) * Rules::kPacket,
            .turnaround = turnaround_};
  }
  std::vector<std::uint64_t> bank_packets() const {
    std::vector<std::uint64_t> all;
    for (const Device<Rules>& device : devices_) {
      for (int bank = 0; bank < Rules::kBanks; ++bank) all.push_back(device.packets(bank));
    }
    return all;
  }
  void dump(std::ostream& out) const {  // for a stall report
    out << Rules::kName << ": " << devices_.size() << ' ' << Rules::kDevices << ", " << reads_ << " packets read, "
        << writes_ << " written, data wires free from " << Rules::kClock << ' ' << dq_free_ << " on\n";
    if (refresh_interval_ != 0) {
      out << Rules::kName << ": next refresh due at " << Rules::kClock << ' ' << refresh_due_ << "\n";
    }
  }
  // Appends every further command, in the order of scheduling; null stops the trace.
  void set_trace(std::vector<IssuedCommand>* sink) { trace_ = sink; }
  void state(Archive& archive) {
    archive("devices", devices_);
    archive.field("wires", [this](Archive::Record& record) {
      record(wires_, column_wires_);
      record.times(last_precharge_, dq_free_);
      record(last_was_write_);
      record.times(last_open_);
      record(last_open_was_refresh_);
    });
    archive.field("refresh", [this](Archive::Record& record) {
      record(refresh_count_);
      record.times(refresh_due_, next_event_);
      static_cast<Derived*>(this)->refresh_state(record);
      const bool is_next = next_event_ == static_cast<Derived*>(this)->next_event();
      record.expect(is_next && refresh_due_ == due_after(refresh_count_), "the clock at which the next refresh is due",
                    refresh_due_);
    });
    archive.field("counters", [this](Archive::Record& record) {
      record(reads_, writes_, misses_, conflicts_, precharges_, turnaround_);
    });
  }

 protected:
  // True if the wires or the device delayed it, not its bank.
  bool precharge(std::uint16_t device, int bank, Tcycle asked) {
    constexpr Command kThis = Command::kPrecharge;
    Device<Rules>& target = devices_[device];
    const Tcycle floor = std::max(asked, target.bank_ready(kThis, bank));
    const Tcycle wanted = std::max({floor, last_precharge_, target.device_ready(kThis)});
    const Tcycle begin = wires_.probe(wanted);
    record(kThis, wanted >= wires_.horizon(), {device, 0, static_cast<std::uint8_t>(bank), 0}, begin, asked);
    wires_.reserve(begin);
    target.template issue<kThis>(bank, 0, begin);
    last_precharge_ = begin;
    ++precharges_;
    return begin > floor;
  }

  // With `leave_gap`, an activation within a packet of the next possible precharge is delayed until after it. Otherwise
  // it would delay that precharge, which the next activation needs, and an RDRAM would open a row every 12 tCYCLE
  // instead of every 8. This is the only command that is later than it could be.
  template <Command kOpens>
  Tcycle activate(const Location& at, Tcycle asked, bool leave_gap) {
    Device<Rules>& device = devices_[at.device];
    Tcycle wanted = std::max({asked, last_open_, device.bank_ready(kOpens, at.bank), device.device_ready(kOpens)});
    if constexpr (Rules::kLeavesGaps) {
      const Tcycle next = last_precharge_ + precharge_gap_;
      leave_gap = leave_gap && wanted + Rules::kCommand > next && wanted < next + Rules::kCommand;
      if (leave_gap) wanted = next + Rules::kCommand;
    } else {
      leave_gap = false;
    }
    const Tcycle begin = wires_.probe(wanted);
    record(kOpens, !leave_gap && wanted >= wires_.horizon(), at, begin, asked);
    wires_.reserve(begin);
    device.template issue<kOpens>(at.bank, at.row, begin);
    last_open_ = begin;
    last_open_was_refresh_ = kOpens == Command::kRefresh;
    return begin;
  }

  // Precharges the conflicting banks, refreshes `at` and returns the time of the refresh.
  Tcycle refresh_next(const Location& at) {
    std::uint32_t open = devices_[at.device].conflicting_banks(Command::kRefresh, at.bank);
    for (; open != 0; open &= open - 1) precharge(at.device, std::countr_zero(open), refresh_due_);
    const Tcycle begin = activate<Command::kRefresh>(at, refresh_due_, false);
    ++refresh_count_;
    refresh_due_ = due_after(refresh_count_);
    return begin;
  }

  std::vector<Device<Rules>> devices_;
  Tcycle last_open_ = 0;  // ACT or refresh
  bool last_open_was_refresh_ = false;
  std::uint64_t refresh_count_ = 0;  // determines device and bank of the next
  Tcycle refresh_due_ = kNever;
  Tcycle next_event_ = kNever;  // the next that refresh_until() performs

 private:
  friend Derived;  // only it constructs a Channel

  // `devices`: at least 1. Each is refreshed once every `refresh_interval`, spread evenly over it; 0: never.
  Channel(const ConstraintTable& timing, std::uint32_t devices, std::uint64_t refresh_interval)
      : column_wires_(timing),
        refresh_interval_(refresh_interval),
        precharge_gap_(timing.delay(Scope::kDevice, Command::kPrecharge, Command::kPrecharge)) {
    if (devices == 0) {
      throw std::invalid_argument(std::string(Rules::kName) + " " + Rules::kDevices +
                                  " of a channel: expected at least 1, got 0");
    }
    devices_.assign(devices, Device<Rules>(timing));
    refresh_due_ = next_event_ = due_after(0);
  }

  // Time at which the next refresh is due after `refreshes` of them.
  Tcycle due_after(std::uint64_t refreshes) const {
    return refresh_interval_ == 0 ? kNever : (refreshes + 1) * refresh_interval_ / devices_.size();
  }

  // Skips most refreshes of a long time without packets, if each refresh ends before the next is due. A round of
  // refreshes covers every bank of every device at least once and lasts longer than any delay. Once two rounds end with
  // the same lateness, all further rounds are equal, and the last one alone leads to the same state as all of them.
  void leave_out(Tcycle t) {
    constexpr std::uint64_t kBanks = 32, kDelays = 64;  // for every standard: kBanks * kDelays clocks exceed any delay
    if (trace_ != nullptr || refresh_interval_ < kDelays * devices_.size()) return;
    const std::uint64_t each = kBanks * (1 + kDelays / refresh_interval_);  // refreshes of a device
    const std::uint64_t round = each * devices_.size(), clocks = each * refresh_interval_;
    if (t < refresh_due_ + 4 * clocks) return;
    const auto late_after_a_round = [&] {
      static_cast<Derived*>(this)->refresh_until(refresh_due_ + clocks - 1);
      return last_open_ - due_after(refresh_count_ - 1);
    };
    const Tcycle late = late_after_a_round();
    const std::uint64_t precharges = precharges_;
    if (late_after_a_round() != late) return;  // refreshes come faster than they can be performed
    const std::uint64_t rounds = (t - refresh_due_) / clocks - 1;
    precharges_ += rounds * (precharges_ - precharges);
    refresh_count_ += rounds * round;
    refresh_due_ = due_after(refresh_count_);
  }

  // Not inline, because most packets hit an open row.
  [[gnu::noinline]] Delay open(const Location& at, Tcycle arrival) {
    std::uint32_t conflicting_banks = devices_[at.device].conflicting_banks(Command::kActivate, at.bank);
    const bool refresh_before = static_cast<Derived*>(this)->held_by_refresh(at, arrival);
    const bool conflict = conflicting_banks != 0;
    bool rows_queue = false;
    if (conflict) {
      rows_queue = precharge(at.device, std::countr_zero(conflicting_banks), arrival);
      conflicting_banks &= conflicting_banks - 1;  // the other neighbour may be open too
      if (conflicting_banks != 0) precharge(at.device, std::countr_zero(conflicting_banks), arrival);
    }
    const Tcycle begin = activate<Command::kActivate>(at, arrival, rows_queue);
    ++misses_;
    conflicts_ += conflict;
    if (begin == arrival) return Delay::kTransfer;
    return refresh_before ? Delay::kRefresh : Delay::kBank;
  }

  // Inline: the memory model is asked for every packet of a simulated frame.
  template <Command kCommand>
  [[gnu::always_inline]] Access serve(const Location& at, Tcycle arrival) {
    advance(arrival);
    constexpr bool kWrite = kCommand == Command::kWrite;
    Device<Rules>& device = devices_[at.device];
    Delay row_delay = Delay::kTransfer;
    if (device.open_row(at.bank) != at.row) [[unlikely]]
      row_delay = open(at, arrival);
    const Tcycle bank_ready = std::max(arrival, device.bank_ready(kCommand, at.bank));
    const Tcycle wires_ready =
        std::max(device.device_ready(kCommand), column_wires_.probe(kCommand, at.device, arrival));
    Tcycle begin = std::max(bank_ready, wires_ready);
    bool tight = true;
    if constexpr (Rules::kOneBus) {
      tight = begin >= wires_.horizon();
      begin = wires_.probe(begin);
      wires_.reserve(begin);
    }
    Access access;
    access.data_begin = column_wires_.data(kCommand, begin);
    access.data_end = access.data_begin + Rules::kPacket;
    if (bank_ready > wires_ready) access.cause = row_delay;
    if (kWrite != last_was_write_) [[unlikely]] {
      const Tcycle without = std::max(dq_free_, column_wires_.data(kCommand, bank_ready));
      turnaround_ += access.data_begin - without;
      last_was_write_ = kWrite;
    }
    column_wires_.reserve(kCommand, at.device, begin);
    device.template issue<kCommand>(at.bank, at.row, begin);
    dq_free_ = access.data_end;
    ++(kWrite ? writes_ : reads_);
    record(kCommand, tight, at, begin, arrival);
    return access;
  }

  void record(Command command, bool tight, const Location& at, Tcycle begin, Tcycle asked) const {
    if (trace_ == nullptr) [[likely]]
      return;
    trace_->push_back({command, tight, at.device, at.row, at.bank, at.column, begin, asked});
  }

  GapWires<Rules::kCommand> wires_;  // of rows, or of all commands
  ColumnWires<Rules::kSwitches> column_wires_;
  Tcycle last_precharge_ = 0;
  Tcycle dq_free_ = 0;
  bool last_was_write_ = false;
  std::uint64_t refresh_interval_;
  std::uint32_t precharge_gap_;
  std::uint64_t reads_ = 0, writes_ = 0, misses_ = 0, conflicts_ = 0, precharges_ = 0, turnaround_ = 0;
  std::vector<IssuedCommand>* trace_ = nullptr;
};

}  // namespace gicube::emu::dram
