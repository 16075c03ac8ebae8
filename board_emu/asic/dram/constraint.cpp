#include "asic/dram/constraint.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace gicube::emu::dram {

using enum Command;
using enum Scope;

const char* to_string(Command command) {
  switch (command) {
    case kActivate: return "ACT";
    case kPrecharge: return "PRE";
    case kRead: return "RD";
    case kWrite: return "WR";
    case kRefresh: return "REFA";
    case kData: return "DATA";
  }
  return "?";
}

const char* to_string(Scope scope) {
  switch (scope) {
    case kBank: return "bank";
    case kNeighbour: return "neighbour";
    case kDevice: return "device";
    case kChannel: return "channel";
    case kOtherDevice: return "other device";
  }
  return "?";
}

ConstraintTable::ConstraintTable(std::string_view standard, Honoured honoured, std::vector<Constraint> rows)
    : rows_(std::move(rows)) {
  for (const Constraint& row : rows_) {
    if (!honoured(row.scope, row.from, row.to)) {
      throw std::invalid_argument(std::string(standard) + " timing " + row.name +
                                  ": expected a pair that the model honours, got " + to_string(row.from) + " to " +
                                  to_string(row.to) + " in a " + to_string(row.scope));
    }
    std::uint32_t& delay = delays_[index(row.scope)][index(row.from)][index(row.to)];
    delay = std::max(delay, row.cycles);
  }
}

}  // namespace gicube::emu::dram
