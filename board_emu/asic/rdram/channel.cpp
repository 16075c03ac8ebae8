#include "asic/rdram/channel.h"

#include <algorithm>
#include <bit>
#include <ostream>
#include <stdexcept>

namespace gicube::emu::rdram {

Channel::Channel(const v1::RdramConfig& config, std::uint32_t devices)
    : column_wires_(Timing(config)), refresh_interval_(config.refresh_interval()) {
  if (devices == 0) throw std::invalid_argument("RDRAM devices of a channel: expected at least 1, got 0");
  const Timing timing(config);
  devices_.assign(devices, Device(timing));
  precharge_gap_ = timing.delay(Scope::kDevice, Command::kPrecharge, Command::kPrecharge);
  recovery_ = timing.delay(Scope::kBank, Command::kRefresh, Command::kActivate);
  refresh_gap_ = timing.delay(Scope::kDevice, Command::kRefresh, Command::kActivate);
  refreshed_open_ = timing.delay(Scope::kBank, Command::kRefresh, Command::kPrecharge);
  if (refresh_interval_ != 0) refresh_due_ = next_event_ = refresh_interval_ / devices;
}

inline bool Channel::precharge(std::uint16_t device, int bank, Tcycle asked) {
  Device& target = devices_[device];
  const Tcycle floor = std::max(asked, target.bank_ready<Command::kPrecharge>(bank));
  const Tcycle wanted = std::max({floor, last_precharge_, target.device_ready<Command::kPrecharge>()});
  const Tcycle begin = row_wires_.probe(wanted);
  const Location at{device, 0, static_cast<std::uint8_t>(bank), 0};
  record(Command::kPrecharge, wanted >= row_wires_.horizon(), at, begin, asked);
  row_wires_.reserve(begin);
  target.issue<Command::kPrecharge>(bank, 0, begin);
  last_precharge_ = begin;
  ++precharges_;
  return begin > floor;
}

template <Command kOpens>
inline Tcycle Channel::activate(const Location& at, Tcycle asked, bool leave_gap) {
  Device& device = devices_[at.device];
  Tcycle wanted = std::max({asked, last_open_, device.ready<kOpens>(at.bank)});
  const Tcycle next_precharge = last_precharge_ + precharge_gap_;
  // Only ever within a packet of where it would be; at once, it would push the next precharge, that the next activation,
  // and rows would open every 12 tCYCLE instead of every 8.
  leave_gap = leave_gap && wanted + kPacket > next_precharge && wanted < next_precharge + kPacket;
  if (leave_gap) wanted = next_precharge + kPacket;
  const Tcycle begin = row_wires_.probe(wanted);
  record(kOpens, !leave_gap && wanted >= row_wires_.horizon(), at, begin, asked);
  row_wires_.reserve(begin);
  device.issue<kOpens>(at.bank, at.row, begin);
  last_open_ = begin;
  return begin;
}

bool Channel::held_by_refresh(const Location& at, Tcycle arrival) const {
  if (last_open_was_refresh_ && arrival < last_open_ + refresh_gap_) return true;
  const std::uint32_t same_amps = neighbours(at.bank) | 1u << at.bank;
  return arrival < refreshed_until_ && at.device == refreshed_.device && (same_amps >> refreshed_.bank & 1) != 0;
}

Delay Channel::open(const Location& at, Tcycle arrival) {
  std::uint32_t in_the_way = devices_[at.device].open_banks() & (neighbours(at.bank) | 1u << at.bank);
  const bool refresh_before = held_by_refresh(at, arrival);
  const bool conflict = in_the_way != 0;
  bool rows_queue = false;
  if (conflict) {
    rows_queue = precharge(at.device, std::countr_zero(in_the_way), arrival);
    in_the_way &= in_the_way - 1;  // what is left is the other neighbour
    if (in_the_way != 0) precharge(at.device, std::countr_zero(in_the_way), arrival);
  }
  const Tcycle begin = activate<Command::kActivate>(at, arrival, rows_queue);
  last_open_was_refresh_ = false;
  ++misses_;
  conflicts_ += conflict;
  if (begin == arrival) return Delay::kTransfer;
  return refresh_before ? Delay::kRefresh : Delay::kBank;
}

void Channel::run_refresh(Tcycle now) {
  while (next_event_ <= now) {
    if (closing_.pending && closing_.due <= refresh_due_) {
      close_refreshed();
    } else {
      refresh_next();
    }
    next_event_ = closing_.pending ? std::min(closing_.due, refresh_due_) : refresh_due_;
  }
}

void Channel::refresh_next() {
  if (closing_.pending) close_refreshed();
  const std::uint64_t devices = devices_.size();
  Location at;
  at.device = static_cast<std::uint16_t>(refresh_count_ % devices);
  at.bank = static_cast<std::uint8_t>(refresh_count_ / devices % kBanks);
  std::uint32_t in_the_way = devices_[at.device].open_banks() & (neighbours(at.bank) | 1u << at.bank);
  for (; in_the_way != 0; in_the_way &= in_the_way - 1)
    precharge(at.device, std::countr_zero(in_the_way), refresh_due_);
  const Tcycle begin = activate<Command::kRefresh>(at, refresh_due_, false);
  last_open_was_refresh_ = true;
  refreshed_ = at;
  refreshed_until_ = begin + recovery_;
  closing_ = {true, at.device, at.bank, begin + refreshed_open_};
  ++refresh_count_;
  refresh_due_ = (refresh_count_ + 1) * refresh_interval_ / devices;
}

void Channel::close_refreshed() {
  closing_.pending = false;
  // A packet that needed the bank may have closed it already.
  if (devices_[closing_.device].open_row(closing_.bank) != kRefreshRow) return;
  precharge(closing_.device, closing_.bank, closing_.due);
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
  counters.dq_busy = (reads_ + writes_) * kPacket;
  counters.turnaround = turnaround_;
  return counters;
}

void Channel::describe(std::ostream& out) const {
  const ChannelCounters now = counters();
  out << "rdram: " << devices_.size() << " devices, " << now.packets_read << " packets read, " << now.packets_written
      << " written, DQ free from tCYCLE " << dq_free_ << " on\n";
  if (refresh_interval_ != 0) out << "rdram: next refresh due at tCYCLE " << refresh_due_ << "\n";
}

}  // namespace gicube::emu::rdram
