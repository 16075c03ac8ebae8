#include "asic/ddr/channel.h"

#include <algorithm>
#include <bit>
#include <ostream>
#include <stdexcept>

namespace gicube::emu::ddr {

Channel::Channel(const v1::DdrConfig& config, std::uint32_t ranks)
    : data_wires_(Timing(config)), refresh_interval_(config.refresh_interval()) {
  if (ranks == 0) throw std::invalid_argument("DDR ranks of a channel: expected at least 1, got 0");
  const Timing timing(config);
  ranks_.assign(ranks, Rank(timing));
  refreshed_until_.assign(ranks, 0);
  refresh_time_ = timing.delay(Scope::kDevice, Command::kRefresh, Command::kActivate);
  if (refresh_interval_ != 0) refresh_due_ = refresh_interval_ / ranks;
}

Tcycle Channel::place(Command command, const Location& at, Tcycle floor, Tcycle asked) {
  const Tcycle begin = command_bus_.probe(floor);
  if (trace_ != nullptr) {
    const bool tight = floor >= command_bus_.horizon();
    trace_->push_back({command, tight, at.device, at.row, at.bank, at.column, begin, asked});
  }
  command_bus_.reserve(begin);
  ranks_[at.device].issue(command, {at.bank, at.row}, begin);
  return begin;
}

void Channel::precharge(const Location& at, Tcycle asked) {
  const Rank& rank = ranks_[at.device];
  const Tcycle floor = std::max(
      {asked, last_precharge_, rank.bank_ready(Command::kPrecharge, at.bank), rank.rank_ready(Command::kPrecharge)});
  last_precharge_ = place(Command::kPrecharge, at, floor, asked);
  ++precharges_;
}

Tcycle Channel::activate(Command command, const Location& at, Tcycle asked) {
  const Rank& rank = ranks_[at.device];
  const Tcycle bank_ready = command == Command::kRefresh ? 0 : rank.bank_ready(command, at.bank);
  last_open_ = place(command, at, std::max({asked, last_open_, bank_ready, rank.rank_ready(command)}), asked);
  return last_open_;
}

Delay Channel::open(const Location& at, Tcycle arrival) {
  const bool refresh_before = arrival < refreshed_until_[at.device];
  const bool conflict = ranks_[at.device].open_row(at.bank) != kClosed;
  if (conflict) precharge(at, arrival);
  const Tcycle begin = activate(Command::kActivate, at, arrival);
  ++misses_;
  conflicts_ += conflict;
  if (begin == arrival) return Delay::kTransfer;
  return refresh_before ? Delay::kRefresh : Delay::kBank;
}

Access Channel::serve(Command command, const Location& at, Tcycle arrival) {
  advance(arrival);
  const bool write = command == Command::kWrite;
  const Rank& rank = ranks_[at.device];
  Delay row_delay = Delay::kTransfer;
  if (rank.open_row(at.bank) != at.row) row_delay = open(at, arrival);
  const Tcycle bank_ready = std::max(arrival, rank.bank_ready(command, at.bank));
  const Tcycle wires_ready = std::max(rank.rank_ready(command), data_wires_.probe(command, at.device, arrival));
  const Tcycle begin = place(command, at, std::max(bank_ready, wires_ready), arrival);
  Access access;
  access.data_begin = data_wires_.data(command, begin);
  access.data_end = access.data_begin + kBurst;
  if (bank_ready > wires_ready) access.cause = row_delay;
  if (write != last_was_write_) {
    turnaround_ += access.data_begin - std::max(dq_free_, data_wires_.data(command, bank_ready));
    last_was_write_ = write;
  }
  data_wires_.reserve(command, at.device, begin);
  dq_free_ = access.data_end;
  ++(write ? writes_ : reads_);
  return access;
}

void Channel::refresh_next() {
  const std::uint64_t ranks = ranks_.size();
  Location at;
  at.device = static_cast<std::uint16_t>(refresh_count_ % ranks);
  for (std::uint32_t open = ranks_[at.device].open_banks(); open != 0; open &= open - 1) {
    at.bank = static_cast<std::uint8_t>(std::countr_zero(open));
    precharge(at, refresh_due_);
  }
  at.bank = 0;
  refreshed_until_[at.device] = activate(Command::kRefresh, at, refresh_due_) + refresh_time_;
  ++refresh_count_;
  refresh_due_ = (refresh_count_ + 1) * refresh_interval_ / ranks;
}

ChannelCounters Channel::counters() const {
  ChannelCounters counters;
  counters.packets_read = reads_;
  counters.packets_written = writes_;
  counters.row_hits = reads_ + writes_ - misses_;
  counters.row_misses = counters.activates = misses_;
  counters.conflicts = conflicts_;
  counters.precharges = precharges_;
  counters.refreshes = refresh_count_;
  counters.dq_busy = (reads_ + writes_) * kBurst;
  counters.turnaround = turnaround_;
  return counters;
}

void Channel::describe(std::ostream& out) const {
  const ChannelCounters now = counters();
  out << "ddr: " << ranks_.size() << " ranks, " << now.packets_read << " packets read, " << now.packets_written
      << " written, data wires free from clock " << dq_free_ << " on\n";
  if (refresh_interval_ != 0) out << "ddr: next refresh due at clock " << refresh_due_ << "\n";
}

}  // namespace gicube::emu::ddr
