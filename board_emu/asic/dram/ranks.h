// Channels of SDRAM ranks, of single or double data rate. All commands share one bus, which takes one command per
// clock. Each rank has one REF every refresh_interval, for which all its banks are precharged.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "asic/dram/channel.h"

namespace gicube::emu::dram {

// The rules that all SDRAM shares (channel.h). A standard adds kName, kDevices, kPacket (the clocks of a
// burst), kWriteLatency (from WR to its data) and kRecoveryStart (from WR to the clock from which tWR counts).
struct RankRules {
  static constexpr const char* kClock = "clock";
  static constexpr Tcycle kCommand = 1;
  static constexpr int kBanks = 4, kBankGroup = 4;
  static constexpr bool kRefreshOpens = false;
  static constexpr bool kOneBus = true, kSwitches = true, kLeavesGaps = false;
  static constexpr std::uint32_t kRankSwitch = 1;  // clocks between the data of two ranks [C]

  static constexpr std::uint32_t requires_precharge(Command opens, int bank) {
    return opens == Command::kRefresh ? ~0u : 1u << bank;
  }
  // Whether the model enforces a constraint between the pair; a table may have no others. A device is a rank.
  static constexpr bool enforced(Scope scope, Command from, Command to) {
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

// The timing of a standard's ranks, with the data sheets' names; BL is a burst's clocks. Every time is a clock, and a
// command's time is the clock in which it is on the wires. `config` is the standard's message; without t_wtr, tWTR is
// 0.
template <typename Rules, typename Config>
ConstraintTable rank_timing(const Config& config) {
  using enum Command;
  using enum Scope;
  const std::uint32_t bl = Rules::kPacket, wl = Rules::kWriteLatency, cl = config.t_cl();
  std::uint32_t t_wtr = 0;
  if constexpr (requires { config.t_wtr(); }) t_wtr = config.t_wtr();
  // Clocks between commands whose data begin `first` and `second` clocks after them, so that `gap` clocks separate the
  // data. The command bus takes one command per clock.
  const auto apart = [bl](std::uint32_t first, std::uint32_t second, std::uint32_t gap) {
    return std::max(first + bl + gap, second + 1) - second;
  };
  return {Rules::kName,
          Rules::enforced,
          {{"tRAS", kActivate, kPrecharge, kBank, config.t_ras()},
           {"tRC", kActivate, kActivate, kBank, config.t_rc()},
           {"tRC", kActivate, kRefresh, kDevice, config.t_rc()},
           {"tRCD", kActivate, kRead, kBank, config.t_rcd()},
           {"tRCD", kActivate, kWrite, kBank, config.t_rcd()},
           {"tRP", kPrecharge, kActivate, kBank, config.t_rp()},
           {"tRP", kPrecharge, kRefresh, kDevice, config.t_rp()},
           {"tRRD", kActivate, kActivate, kDevice, config.t_rrd()},
           {"tRFC", kRefresh, kActivate, kDevice, config.t_rfc()},
           {"tRFC", kRefresh, kRefresh, kDevice, config.t_rfc()},
           {"BL", kRead, kPrecharge, kBank, bl},
           {"tWR", kWrite, kPrecharge, kBank, Rules::kRecoveryStart + config.t_wr()},
           {"WL+BL+tWTR", kWrite, kRead, kDevice, wl + bl + t_wtr},
           {"BL", kRead, kRead, kChannel, bl},
           {"BL", kWrite, kWrite, kChannel, bl},
           {"CL+BL+1-WL", kRead, kWrite, kChannel, apart(cl, wl, 1)},
           {"WL+BL-CL", kWrite, kRead, kChannel, apart(wl, cl, 0)},
           {"BL+switch", kRead, kRead, kOtherDevice, bl + Rules::kRankSwitch},
           {"WL+BL+switch-CL", kWrite, kRead, kOtherDevice, apart(wl, cl, Rules::kRankSwitch)},
           {"CL", kRead, kData, kChannel, cl},
           {"WL", kWrite, kData, kChannel, wl}}};
}

template <typename Rules>
class RankChannel : public Channel<RankChannel<Rules>, Rules> {
 public:
  // `config`: the standard's message. `ranks` from 1 on. Throws std::invalid_argument for 0.
  template <typename Config>
  RankChannel(const Config& config, std::uint32_t ranks)
      : Channel<RankChannel, Rules>(rank_timing<Rules>(config), ranks, config.refresh_interval()),
        refreshed_until_(ranks),
        refresh_time_(config.t_rfc()) {}

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

  std::vector<Tcycle> refreshed_until_;  // by rank: the first clock in which an ACT is legal after the last REF
  std::uint32_t refresh_time_;           // tRFC
};

}  // namespace gicube::emu::dram
