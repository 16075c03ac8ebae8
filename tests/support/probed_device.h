// A memory device that takes commands chosen at run time, and reports when they are legal.
#pragma once

#include <algorithm>

#include "asic/dram/device.h"

namespace gicube::emu::dram {

struct BankAddress {
  int bank = 0;
  std::int32_t row = 0;  // only for kActivate
};

template <typename Rules>
class ProbedDevice : public Device<Rules> {
 public:
  using Device<Rules>::Device;

  // The earliest time from `t` on at which the command is legal for this device; kNever if a bank is in the wrong
  // state. ACT and REFA need the banks of requires_precharge() precharged, RD and WR need an open bank, PRE needs one
  // that is not precharged. Does not consider the channel's wires.
  Tcycle probe(Command command, BankAddress at, Tcycle t) const {
    const bool opens = command == Command::kActivate || command == Command::kRefresh;
    const bool legal = opens                            ? this->conflicting_banks(command, at.bank) == 0
                       : command == Command::kPrecharge ? this->open_row(at.bank) != kClosed
                                                        : this->open_row(at.bank) >= 0;
    return legal ? std::max({t, this->bank_ready(command, at.bank), this->device_ready(command)}) : kNever;
  }
  // Mask of the banks that are not precharged.
  std::uint32_t open_banks() const {
    std::uint32_t open = 0;
    for (int bank = 0; bank < Rules::kBanks; ++bank) open |= this->open_row(bank) != kClosed ? 1u << bank : 0u;
    return open;
  }
  // Performs the command at `t`, which probe() must have allowed.
  void issue(Command command, BankAddress at, Tcycle t) {
    using Base = Device<Rules>;
    switch (command) {
      case Command::kActivate: return Base::template issue<Command::kActivate>(at.bank, at.row, t);
      case Command::kRefresh: return Base::template issue<Command::kRefresh>(at.bank, at.row, t);
      case Command::kPrecharge: return Base::template issue<Command::kPrecharge>(at.bank, at.row, t);
      case Command::kRead: return Base::template issue<Command::kRead>(at.bank, at.row, t);
      default: return Base::template issue<Command::kWrite>(at.bank, at.row, t);
    }
  }
};

}  // namespace gicube::emu::dram
