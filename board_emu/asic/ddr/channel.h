// One channel of DDR SDRAM: all commands share one bus, one a clock. Each rank has one REF every refresh_interval, for which
// all its banks are precharged.
#pragma once

#include <cstdint>
#include <vector>

#include "asic/dram/channel.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::ddr {

using dram::Access, dram::BankAddress, dram::ChannelCounters, dram::Command, dram::Constraint, dram::Delay,
    dram::IssuedCommand, dram::kClosed, dram::kNever, dram::Location, dram::Scope, dram::Tcycle;

inline constexpr std::uint32_t kBurst = 1;         // clocks of a burst of two beats
inline constexpr std::uint32_t kWriteLatency = 1;  // WR to data
inline constexpr std::uint32_t kRankSwitch = 1;    // clocks between the data of two ranks, for the strobes [C]

// What a channel needs to know (dram/channel.h).
struct Rules {
  static constexpr const char *kName = "ddr", *kDevice = "DDR rank", *kDevices = "ranks", *kClock = "clock";
  static constexpr Tcycle kPacket = kBurst;
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

using Rank = dram::Device<Rules>;

// DDR SDRAM's timing as a table of constraints with the data sheets' names.
//
// The part: 128 Mbit chips of 4 banks, 4096 rows and 1024 columns of 8 bits at 100 MHz (DDR-200, PC1600, CL 2). Their times
// are those of Samsung's modules M312L6420 "A0"; docs/reference/hardware.md has the source of each. Nine side by side are a
// rank of 72 data wires: 64 and the 8 of a module with error correction, which a voxel's 36 bits need. A burst of two beats,
// the shortest, is 144 bits in one clock: one packet of four voxels, at the RDRAM's 1.6 GB/s.
//
// Convention: every time is a clock (tCK = 10 ns), and a command's time is the clock in which it is on the wires. WR's data
// begin one clock after it (tDQSS nominal); tWR and tWTR count from the first clock after the last data.
class Timing : public dram::ConstraintTable {
 public:
  explicit Timing(const v1::DdrConfig& config);
  // Throws std::invalid_argument if a row names a pair that is not honoured().
  explicit Timing(std::vector<Constraint> rows);
};

class Channel : public dram::Channel<Channel, Rules> {
 public:
  // `ranks` from 1 on. Throws std::invalid_argument for 0.
  Channel(const v1::DdrConfig& config, std::uint32_t ranks)
      : dram::Channel<Channel, Rules>(Timing(config), ranks, config.refresh_interval()),
        refreshed_until_(ranks),
        refresh_time_(Timing(config).delay(Scope::kDevice, Command::kRefresh, Command::kActivate)) {}

 private:
  friend dram::Channel<Channel, Rules>;

  bool held_by_refresh(const Location& at, Tcycle arrival) const { return arrival < refreshed_until_[at.device]; }
  void refresh_until(Tcycle now) {
    while (refresh_due_ <= now) {
      const Location at{.device = static_cast<std::uint16_t>(refresh_count_ % devices_.size())};
      refreshed_until_[at.device] = refresh_next(at) + refresh_time_;
    }
    next_event_ = refresh_due_;
  }

  std::vector<Tcycle> refreshed_until_;  // by rank: its first clock for an ACT after the last REF
  std::uint32_t refresh_time_;           // tRFC
};

}  // namespace gicube::emu::ddr
