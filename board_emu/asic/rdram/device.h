// One RDRAM device: the state of its 32 banks, and when a command may come. It has no clock; callers pass the tCYCLE.
//
// Commands may be issued in another order than that of their times, as long as those which a constraint ties together are
// issued in the order of their times. Inline, because a packet takes three of these calls.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "asic/rdram/timing.h"

namespace gicube::emu::rdram {

inline constexpr int kBanks = 32;
inline constexpr int kBankGroup = 16;            // the split of "32s": banks 15 and 16 share no sense amp (assumed)
inline constexpr std::int32_t kClosed = -1;      // instead of an open row
inline constexpr std::int32_t kRefreshRow = -2;  // open at the row of the device's own refresh counter

// The banks, as a mask, that share a sense amp with `bank`.
constexpr std::uint32_t neighbours(int bank) {
  constexpr std::uint32_t kLast = 0x8000'8000;  // banks 15 and 31
  const std::uint32_t own = 1u << bank;
  return (own & ~kLast) << 1 | (own >> 1 & ~kLast);
}

struct BankAddress {
  int bank = 0;          // 0..31
  std::int32_t row = 0;  // only for kActivate
};

class Device {
 public:
  explicit Device(const Timing& timing);

  // The earliest tCYCLE from `t` on at which the command is legal here; kNever if the bank is in the wrong state: ACT and
  // REFA need it and its neighbours precharged, RD and WR need it open, PRE needs something to precharge. The channel's
  // wires are not this device's matter.
  Tcycle probe(Command command, BankAddress at, Tcycle t) const;
  // Carries the command out at `t`, which probe() must have allowed.
  void issue(Command command, BankAddress at, Tcycle t);

  std::int32_t open_row(int bank) const { return banks_[place(bank)].row; }
  std::uint32_t open_banks() const { return open_; }  // mask

  // The same without looking at the state, for a caller that knows it and the command.
  template <Command kCommand>
  Tcycle ready(int bank) const {
    return std::max(bank_ready<kCommand>(bank), device_ready<kCommand>());
  }
  // The parts of it: what commands to this bank and its neighbours allow, and those to the whole device.
  template <Command kCommand>
  Tcycle bank_ready(int bank) const {
    return banks_[place(bank)].ready[index(kCommand)];
  }
  template <Command kCommand>
  Tcycle device_ready() const {
    return ready_[index(kCommand)];
  }
  template <Command kFrom>
  void issue(int bank, std::int32_t row, Tcycle t);

 private:
  using Ready = std::array<Tcycle, kCommands - 1>;  // per command, without kData
  using Delays = std::array<std::array<std::uint32_t, kCommands - 1>, kCommands - 1>;
  static constexpr auto kTargets = std::make_index_sequence<kCommands - 1>();

  struct Bank {
    Ready ready{};
    std::int32_t row = kClosed;
  };

  template <Scope kScope, Command kFrom, std::size_t... kTo>
  static void raise(Ready& ready, const Delays& delays, Tcycle t, std::index_sequence<kTo...>) {
    const auto one = [&]<std::size_t kOne>() {
      if constexpr (honoured(kScope, kFrom, static_cast<Command>(kOne))) {
        ready[kOne] = std::max(ready[kOne], t + delays[index(kFrom)][kOne]);
      }
    };
    (one.template operator()<kTo>(), ...);
  }

  // A place before and after each group, so that every bank has two neighbours to tell.
  static constexpr std::size_t place(int bank) {
    const auto plain = static_cast<std::size_t>(bank);
    return plain + 1 + plain / kBankGroup * 2;
  }

  std::array<Bank, kBanks + 4> banks_{};
  Ready ready_{};           // of the whole device
  std::uint32_t open_ = 0;  // mask of banks that are not precharged
  Delays bank_delays_{}, neighbour_delays_{}, device_delays_{};
};

template <Command kFrom>
inline void Device::issue(int bank, std::int32_t row, Tcycle t) {
  Bank& own = banks_[place(bank)];
  raise<Scope::kBank, kFrom>(own.ready, bank_delays_, t, kTargets);
  raise<Scope::kDevice, kFrom>(ready_, device_delays_, t, kTargets);
  if constexpr (kFrom == Command::kPrecharge) {
    for (Bank* other : {&own - 1, &own + 1}) {
      raise<Scope::kNeighbour, kFrom>(other->ready, neighbour_delays_, t, kTargets);
    }
    own.row = kClosed;
    open_ &= ~(1u << bank);
  } else if constexpr (kFrom == Command::kActivate || kFrom == Command::kRefresh) {
    own.row = kFrom == Command::kRefresh ? kRefreshRow : row;
    open_ |= 1u << bank;
  }
}

}  // namespace gicube::emu::rdram
