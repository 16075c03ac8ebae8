#include "asic/rdram/device.h"

#include <stdexcept>

namespace gicube::emu::rdram {

Device::Device(const Timing& timing) {
  const auto fill = [&timing](Delays& delays, Scope scope) {
    for (std::size_t from = 0; from < delays.size(); ++from) {
      for (std::size_t to = 0; to < delays.size(); ++to) {
        delays[from][to] = timing.delay(scope, static_cast<Command>(from), static_cast<Command>(to));
      }
    }
  };
  fill(bank_delays_, Scope::kBank);
  fill(neighbour_delays_, Scope::kNeighbour);
  fill(device_delays_, Scope::kDevice);
}

Tcycle Device::probe(Command command, BankAddress at, Tcycle t) const {
  const std::uint32_t own = 1u << at.bank;
  switch (command) {
    case Command::kActivate:
      return (open_ & (own | neighbours(at.bank))) != 0 ? kNever : std::max(t, ready<Command::kActivate>(at.bank));
    case Command::kRefresh:
      return (open_ & (own | neighbours(at.bank))) != 0 ? kNever : std::max(t, ready<Command::kRefresh>(at.bank));
    case Command::kPrecharge: return (open_ & own) == 0 ? kNever : std::max(t, ready<Command::kPrecharge>(at.bank));
    case Command::kRead: return open_row(at.bank) < 0 ? kNever : std::max(t, ready<Command::kRead>(at.bank));
    case Command::kWrite: return open_row(at.bank) < 0 ? kNever : std::max(t, ready<Command::kWrite>(at.bank));
    case Command::kData: break;
  }
  throw std::invalid_argument("RDRAM device: expected a command, got data");
}

void Device::issue(Command command, BankAddress at, Tcycle t) {
  switch (command) {
    case Command::kActivate: return issue<Command::kActivate>(at.bank, at.row, t);
    case Command::kRefresh: return issue<Command::kRefresh>(at.bank, at.row, t);
    case Command::kPrecharge: return issue<Command::kPrecharge>(at.bank, at.row, t);
    case Command::kRead: return issue<Command::kRead>(at.bank, at.row, t);
    case Command::kWrite: return issue<Command::kWrite>(at.bank, at.row, t);
    case Command::kData: break;
  }
  throw std::invalid_argument("RDRAM device: expected a command, got data");
}

}  // namespace gicube::emu::rdram
