// Channels of SDRAM ranks, of single or double data rate: all commands share one bus, one a clock. Each rank has one REF every
// refresh_interval, for which all its banks are precharged.
#pragma once

#include <cstdint>
#include <vector>

#include "asic/dram/channel.h"

namespace gicube::emu::dram {

// What a channel needs to know (channel.h), but for kName, kDevice, kDevices and kPacket, the clocks of a burst.
struct RankRules {
  static constexpr const char* kClock = "clock";
  static constexpr Tcycle kCommand = 1;
  static constexpr int kBanks = 4, kBankGroup = 4;
  static constexpr bool kRefreshOpens = false;
  static constexpr bool kOneBus = true, kSwitches = true, kLeavesGaps = false;

  static constexpr std::uint32_t must_be_closed(Command opens, int bank) {
    return opens == Command::kRefresh ? ~0u : 1u << bank;
  }
  // Pairs between which the model can hold a constraint; a table may have no others. A device is a rank.
  static constexpr bool honoured(Scope scope, Command from, Command to) {
    constexpr auto column = [](Command c) { return c == Command::kRead || c == Command::kWrite; };
    constexpr auto opens = [](Command c) { return c == Command::kActivate || c == Command::kRefresh; };
    switch (scope) {
      case Scope::kBank:
        return (from == Command::kActivate && to != Command::kRefresh && to != Command::kData) ||
               (from == Command::kPrecharge && to == Command::kActivate) || (column(from) && to == Command::kPrecharge);
      case Scope::kDevice:
        return (opens(from) && opens(to)) || (from == Command::kPrecharge && to == Command::kRefresh) ||
               (from == Command::kWrite && to == Command::kRead);
      case Scope::kChannel: return column(from) && (column(to) || to == Command::kData);
      case Scope::kOtherDevice: return column(from) && column(to);
      case Scope::kNeighbour: break;
    }
    return false;
  }
};

template <typename Rules>
class RankChannel : public Channel<RankChannel<Rules>, Rules> {
 public:
  // `ranks` from 1 on. Throws std::invalid_argument for 0.
  RankChannel(const ConstraintTable& timing, std::uint32_t ranks, std::uint64_t refresh_interval)
      : Channel<RankChannel, Rules>(timing, ranks, refresh_interval),
        refreshed_until_(ranks),
        refresh_time_(timing.delay(Scope::kDevice, Command::kRefresh, Command::kActivate)) {}

 private:
  friend Channel<RankChannel, Rules>;

  bool held_by_refresh(const Location& at, Tcycle arrival) const { return arrival < refreshed_until_[at.device]; }
  void refresh_until(Tcycle now) {
    while (this->refresh_due_ <= now) {
      const Location at{.device = static_cast<std::uint16_t>(this->refresh_count_ % this->devices_.size())};
      refreshed_until_[at.device] = this->refresh_next(at) + refresh_time_;
    }
    this->next_event_ = next_event();
  }
  Tcycle next_event() const { return this->refresh_due_; }
  void refresh_state(Archive::Record& record) { record.times(refreshed_until_); }

  std::vector<Tcycle> refreshed_until_;  // by rank: its first clock for an ACT after the last REF
  std::uint32_t refresh_time_;           // tRFC
};

}  // namespace gicube::emu::dram
