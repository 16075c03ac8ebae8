#include "asic/ddr/rank.h"

#include <stdexcept>

namespace gicube::emu::ddr {

Rank::Rank(const Timing& timing) {
  for (std::size_t from = 0; from < bank_delays_.size(); ++from) {
    for (std::size_t to = 0; to < bank_delays_.size(); ++to) {
      const auto pair = [&](Scope scope) {
        return timing.delay(scope, static_cast<Command>(from), static_cast<Command>(to));
      };
      bank_delays_[from][to] = pair(Scope::kBank);
      rank_delays_[from][to] = pair(Scope::kDevice);
    }
  }
}

Tcycle Rank::probe(Command command, BankAddress at, Tcycle t) const {
  const bool open = (open_ >> at.bank & 1) != 0;
  switch (command) {
    case Command::kActivate:
      if (open) return kNever;
      break;
    case Command::kRefresh: return open_ != 0 ? kNever : std::max(t, rank_ready(command));
    case Command::kPrecharge:
    case Command::kRead:
    case Command::kWrite:
      if (!open) return kNever;
      break;
    case Command::kData: throw std::invalid_argument("DDR rank: expected a command, got data");
  }
  return std::max({t, bank_ready(command, at.bank), rank_ready(command)});
}

void Rank::issue(Command command, BankAddress at, Tcycle t) {
  if (command == Command::kData) throw std::invalid_argument("DDR rank: expected a command, got data");
  Bank& bank = banks_[at.bank];
  raise(bank.ready, bank_delays_[index(command)], t);
  raise(ready_, rank_delays_[index(command)], t);
  if (command == Command::kActivate) {
    bank.row = at.row;
    open_ |= 1u << at.bank;
  } else if (command == Command::kPrecharge) {
    bank.row = kClosed;
    open_ &= ~(1u << at.bank);
  }
}

}  // namespace gicube::emu::ddr
