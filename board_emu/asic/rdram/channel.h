// One channel of Direct RDRAMs, with separate wires for rows and columns. Each device has one REFA every
// refresh_interval, to its banks in turn [H1401-H1405].
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "asic/dram/channel.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::rdram {

using dram::Access, dram::ChannelCounters, dram::Command, dram::Constraint, dram::IssuedCommand, dram::kClosed,
    dram::kNever, dram::Location, dram::Scope, dram::Tcycle;

inline constexpr std::uint32_t kPacket = 4;  // tPACK: a packet of ROW, COL or DQ (Siemens HYB25x144180C)

// Mask of the banks that share a sense amp with `bank`.
constexpr std::uint32_t neighbours(int bank) {
  constexpr std::uint32_t kLast = 0x8000'8000;  // banks 15 and 31
  const std::uint32_t own = 1u << bank;
  return (own & ~kLast) << 1 | (own >> 1 & ~kLast);
}

// The standard's rules (dram/channel.h).
struct Rules {
  static constexpr const char *kName = "rdram", *kDevices = "devices", *kClock = "tCYCLE";
  static constexpr Tcycle kCommand = rdram::kPacket, kPacket = rdram::kPacket;
  static constexpr int kBanks = 32;
  static constexpr int kBankGroup = 16;  // the split of "32s": banks 15 and 16 share no sense amp (assumed)
  static constexpr bool kRefreshOpens = true;
  static constexpr bool kOneBus = false, kSwitches = false, kLeavesGaps = true;

  static constexpr std::uint32_t requires_precharge(Command, int bank) { return neighbours(bank) | 1u << bank; }
  // Whether the model enforces a constraint between the pair; a table may have no others.
  static constexpr bool enforced(Scope scope, Command from, Command to) {
    constexpr auto opens = [](Command c) { return c == Command::kActivate || c == Command::kRefresh; };
    constexpr auto column = [](Command c) { return c == Command::kRead || c == Command::kWrite; };
    constexpr auto row = [opens](Command c) { return opens(c) || c == Command::kPrecharge; };
    switch (scope) {
      case Scope::kBank:
        return (opens(from) && row(to)) || (from == Command::kActivate && column(to)) ||
               (from == Command::kPrecharge && opens(to)) || (column(from) && to == Command::kPrecharge);
      case Scope::kNeighbour: return from == Command::kPrecharge && opens(to);
      case Scope::kDevice:
        return (opens(from) && opens(to)) || (from == Command::kPrecharge && to == Command::kPrecharge) ||
               (from == Command::kWrite && to == Command::kRead);
      case Scope::kChannel:
        return (row(from) && row(to)) || (column(from) && column(to)) || (column(from) && to == Command::kData);
      case Scope::kOtherDevice: break;
    }
    return false;
  }
};

// The RDRAM's timing as a table of constraints with the data book's names.
//
// Times are in tCYCLE (2.5 ns at 800 MHz). A command's time is the tCYCLE in which its packet begins on the ROW or COL
// wires. All packets last tPACK = 4. The data book counts intervals from end to end of packets, this table from begin
// to begin: both are equal. Where the data book counts from the end of one packet to the begin of another, the row adds
// tPACK: data begin tPACK + tCAC after the begin of the RD packet, and a read of a device that was just written waits
// tRTR + tPACK, because the packet that retires the write buffer comes between.
dram::ConstraintTable timing(const v1::RdramConfig& config);

class Channel : public dram::Channel<Channel, Rules> {
 public:
  // `devices`: at least 1. Throws std::invalid_argument for 0.
  Channel(const v1::RdramConfig& config, std::uint32_t devices);

 private:
  friend dram::Channel<Channel, Rules>;

  struct Closing {
    bool pending = false;  // a refreshed bank is still open
    std::uint16_t device = 0;
    int bank = 0;
    Tcycle due = 0;
  };
  void refresh_state(Archive::Record& record) {
    record(closing_.pending);
    record.at_most(closing_.device, static_cast<std::uint16_t>(devices_.size() - 1));
    record.at_most(closing_.bank, Rules::kBanks - 1);
    record.times(closing_.due);
    record(refreshed_.device);
    record.times(refreshed_until_);
    record.at_most(refreshed_.bank, Rules::kBanks - 1);
  }

  void refresh_until(Tcycle now);
  Tcycle next_event() const { return closing_.pending ? std::min(closing_.due, refresh_due_) : refresh_due_; }
  bool held_by_refresh(const Location& at, Tcycle arrival) const;
  void refresh();
  void close_refreshed();

  std::uint32_t recovery_;        // tRC after REFA
  std::uint32_t refresh_gap_;     // tRR after REFA
  std::uint32_t refreshed_open_;  // tRAS after REFA
  Closing closing_;
  Location
      refreshed_{};  // the bank refreshed last; refreshed_until_ is the first time at which it can be activated again
  Tcycle refreshed_until_ = 0;
};

}  // namespace gicube::emu::rdram
