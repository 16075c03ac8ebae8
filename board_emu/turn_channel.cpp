#include "turn_channel.h"

namespace gicube::emu {

using rdram::Command;
using rdram::Scope;
using rdram::Tcycle;

TurnChannel::TurnChannel(const v1::RdramConfig& config, std::uint32_t devices)
    : devices_(devices), banks_(std::size_t{devices} * rdram::kBanks), refresh_interval_(config.refresh_interval()) {
  const rdram::Timing timing(config);
  read_gap_ = timing.delay(Scope::kChannel, Command::kRead, Command::kRead);
  data_end_ = timing.delay(Scope::kChannel, Command::kRead, Command::kData) + rdram::kPacket;
  open_to_open_ = timing.delay(Scope::kDevice, Command::kActivate, Command::kActivate);
  open_to_read_ = timing.delay(Scope::kBank, Command::kActivate, Command::kRead);
  open_to_close_ = timing.delay(Scope::kBank, Command::kActivate, Command::kPrecharge);
  read_to_close_ = timing.delay(Scope::kBank, Command::kRead, Command::kPrecharge);
  close_to_open_ = timing.delay(Scope::kBank, Command::kPrecharge, Command::kActivate);
  close_to_close_ = timing.delay(Scope::kDevice, Command::kPrecharge, Command::kPrecharge);
  again_ = timing.delay(Scope::kBank, Command::kActivate, Command::kActivate);
  refresh_to_open_ = timing.delay(Scope::kDevice, Command::kRefresh, Command::kActivate);
  refreshed_again_ = timing.delay(Scope::kBank, Command::kRefresh, Command::kActivate);
  if (refresh_interval_ != 0) refresh_due_ = refresh_interval_ / devices;
}

// Closes the bank and those that share a sense amp with it.
inline void TurnChannel::close_around(std::uint16_t number, int bank, Tcycle asked) {
  Device& device = devices_[number];
  const std::uint32_t around = rdram::neighbours(bank) | 1u << bank;
  Bank* const banks = banks_.data() + std::size_t{number} * rdram::kBanks;
  for (std::uint32_t closing = device.open & around; closing != 0; closing &= closing - 1) {
    const int which = std::countr_zero(closing);
    const Tcycle begin = std::max({asked, banks[which].closes, device.closes});
    device.closes = begin + close_to_close_;
    banks[which].row = rdram::kClosed;
    for (std::uint32_t held = rdram::neighbours(which) | 1u << which; held != 0; held &= held - 1) {
      Bank& waits = banks[std::countr_zero(held)];
      waits.opens = std::max(waits.opens, begin + close_to_open_);
    }
    ++closed_;
  }
  device.open &= ~around;
}

void TurnChannel::open(const rdram::Location& at, Bank& bank, Tcycle arrival) {
  Device& device = devices_[at.device];
  if ((device.open & (rdram::neighbours(at.bank) | 1u << at.bank)) != 0) {
    ++conflicts_;
    close_around(at.device, at.bank, arrival);
  }
  const Tcycle begin = std::max({arrival, bank.opens, device.opens});
  device.opens = begin + open_to_open_;
  device.open |= 1u << at.bank;
  bank = {at.row, begin + again_, begin + open_to_read_, begin + open_to_close_};
  ++misses_;
}

void TurnChannel::refresh(Tcycle now) {
  while (refresh_due_ <= now) {
    const auto device = static_cast<std::uint16_t>(refreshes_ % devices_.size());
    const auto bank = static_cast<int>(refreshes_ / devices_.size() % rdram::kBanks);
    close_around(device, bank, refresh_due_);
    Bank& refreshed = banks_[std::size_t{device} * rdram::kBanks + static_cast<std::size_t>(bank)];
    const Tcycle begin = std::max({refresh_due_, refreshed.opens, devices_[device].opens});
    refreshed.opens = begin + refreshed_again_;
    devices_[device].opens = begin + refresh_to_open_;
    ++refreshes_;
    refresh_due_ = (refreshes_ + 1) * refresh_interval_ / devices_.size();
  }
}

rdram::ChannelCounters TurnChannel::counters() const {
  rdram::ChannelCounters counters;
  counters.packets_read = packets_;
  counters.row_hits = packets_ - misses_;
  counters.row_misses = counters.activates = misses_;
  counters.conflicts = conflicts_;
  counters.precharges = closed_;
  counters.refreshes = refreshes_;
  counters.dq_busy = packets_ * rdram::kPacket;
  return counters;
}

}  // namespace gicube::emu
