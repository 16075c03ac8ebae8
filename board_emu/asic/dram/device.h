// One device of a channel (an RDRAM, or a rank of SDRAM): the state of its banks and the earliest times of commands. It
// has no clock; callers pass the time.
//
// Commands may be issued in another order than that of their times, except those that a constraint relates to each
// other. Inline, because a packet takes three of these calls.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "asic/dram/constraint.h"
#include "gicube/archive.h"

namespace gicube::emu::dram {

inline constexpr std::int32_t kClosed = -1;      // in place of an open row
inline constexpr std::int32_t kRefreshRow = -2;  // the open row is that of the device's own refresh counter

// `Rules`: the standard's kBanks, kBankGroup, kRefreshOpens, requires_precharge() and enforced().
template <typename Rules>
class Device {
 public:
  explicit Device(const ConstraintTable& timing) : delays_(timing.delays()) {}

  // Performs a command at `t`. Its bank must be in the right state, and the command legal by bank_ready() and
  // device_ready(). `row`: only for kActivate.
  template <Command kFrom>
  void issue(int bank, std::int32_t row, Tcycle t) {
    Bank& own = banks_[slot(bank)];
    raise<Scope::kBank, kFrom>(own.ready, t, kTargets);
    raise<Scope::kDevice, kFrom>(ready_, t, kTargets);
    if constexpr (kFrom == Command::kRead || kFrom == Command::kWrite) ++own.packets;
    if constexpr (kFrom == Command::kPrecharge) {
      for (Bank* other : {&own - 1, &own + 1}) raise<Scope::kNeighbour, kFrom>(other->ready, t, kTargets);
      own.row = kClosed;
      open_ &= ~(1u << bank);
    } else if constexpr (kFrom == Command::kActivate || (kFrom == Command::kRefresh && Rules::kRefreshOpens)) {
      own.row = kFrom == Command::kRefresh ? kRefreshRow : row;
      open_ |= 1u << bank;
    }
  }

  std::int32_t open_row(int bank) const { return banks_[slot(bank)].row; }
  std::uint64_t packets(int bank) const { return banks_[slot(bank)].packets; }  // read and written
  // Mask of the conflicting banks: those to be precharged before `opens` (ACT or REFA) of `bank`.
  std::uint32_t conflicting_banks(Command opens, int bank) const {
    return open_ & Rules::requires_precharge(opens, bank);
  }

  // Earliest times by the timing alone, whatever the state: by commands to this bank and its neighbours, and to the
  // device.
  Tcycle bank_ready(Command command, int bank) const { return banks_[slot(bank)].ready[index(command)]; }
  Tcycle device_ready(Command command) const { return ready_[index(command)]; }
  void state(Archive::Record& record) {
    record(banks_);
    record.times(ready_);
    record.at_most(open_, static_cast<std::uint32_t>((std::uint64_t{1} << Rules::kBanks) - 1));
  }

 private:
  using Ready = std::array<Tcycle, kCommands - 1>;  // per command, without kData
  static constexpr auto kTargets = std::make_index_sequence<kCommands - 1>();

  struct Bank {
    Ready ready{};
    std::int32_t row = kClosed;
    std::uint64_t packets = 0;

    void state(Archive::Record& record) {
      record.times(ready);
      record(row, packets);
    }
  };

  template <Scope kScope, Command kFrom, std::size_t... kTo>
  void raise(Ready& ready, Tcycle t, std::index_sequence<kTo...>) const {
    const auto one = [&]<std::size_t kOne>() {
      if constexpr (Rules::enforced(kScope, kFrom, static_cast<Command>(kOne))) {
        ready[kOne] = std::max(ready[kOne], t + delays_[index(kScope)][index(kFrom)][kOne]);
      }
    };
    (one.template operator()<kTo>(), ...);
  }

  // Index in banks_. Each group of banks that share sense amps has a spare entry before and after it, so that every
  // bank has two neighbours to update.
  static constexpr std::size_t slot(int bank) {
    const auto plain = static_cast<std::size_t>(bank);
    return plain + 1 + plain / Rules::kBankGroup * 2;
  }

  std::array<Bank, Rules::kBanks + 2 * (Rules::kBanks / Rules::kBankGroup)> banks_{};
  Ready ready_{};           // of the whole device
  std::uint32_t open_ = 0;  // mask of banks that are not precharged
  Delays delays_;
};

}  // namespace gicube::emu::dram
