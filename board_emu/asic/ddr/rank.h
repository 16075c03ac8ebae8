// One rank of DDR SDRAM, nine chips in step: the state of its 4 banks, and when a command may come. It has no clock; callers
// pass it.
//
// Commands may be issued in another order than that of their times, as long as those which a constraint ties together are
// issued in the order of their times.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "asic/ddr/timing.h"

namespace gicube::emu::ddr {

inline constexpr std::size_t kBanks = 4;
inline constexpr std::int32_t kClosed = -1;  // instead of an open row

struct BankAddress {
  std::uint32_t bank = 0;  // 0..3; of no matter to kRefresh
  std::int32_t row = 0;    // only for kActivate
};

class Rank {
 public:
  explicit Rank(const Timing& timing);

  // The earliest clock from `t` on at which the command is legal here; kNever if a bank is in the wrong state: ACT needs its
  // own precharged and REF all, RD and WR need theirs open, PRE needs something to precharge. The channel's wires are not
  // this rank's matter.
  Tcycle probe(Command command, BankAddress at, Tcycle t) const;
  // Carries the command out at `t`, which probe() must have allowed.
  void issue(Command command, BankAddress at, Tcycle t);

  std::int32_t open_row(std::uint32_t bank) const { return banks_[bank].row; }
  std::uint32_t open_banks() const { return open_; }  // mask

  // The same without looking at the state: what commands to this bank allow, and those to the whole rank.
  Tcycle bank_ready(Command command, std::uint32_t bank) const { return banks_[bank].ready[index(command)]; }
  Tcycle rank_ready(Command command) const { return ready_[index(command)]; }

 private:
  using Ready = std::array<Tcycle, kCommands - 1>;  // per command, without kData
  using Delays = std::array<std::array<std::uint32_t, kCommands - 1>, kCommands - 1>;

  struct Bank {
    Ready ready{};
    std::int32_t row = kClosed;
  };

  // A pair without a constraint has no delay, and raises nothing.
  static void raise(Ready& ready, const std::array<std::uint32_t, kCommands - 1>& delays, Tcycle t) {
    for (std::size_t to = 0; to < ready.size(); ++to) {
      if (delays[to] != 0) ready[to] = std::max(ready[to], t + delays[to]);
    }
  }

  std::array<Bank, kBanks> banks_{};
  Ready ready_{};
  std::uint32_t open_ = 0;
  Delays bank_delays_{}, rank_delays_{};
};

}  // namespace gicube::emu::ddr
