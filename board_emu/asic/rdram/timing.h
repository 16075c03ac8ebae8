// The RDRAM's timing as a table of constraints with the data book's names.
//
// Convention: every time is a tCYCLE (2.5 ns at 800 MHz), and a command's time is the tCYCLE in which its packet begins on
// the ROW or COL wires. All packets last tPACK = 4, so an interval between two packets is the same from end to end, as the
// data book counts it, as from begin to begin, as this table counts it. Where the data book counts from one packet's end
// to another's begin, the row adds tPACK: data begin tPACK + tCAC after the begin of the RD packet, and a read of a
// device that was just written waits tRTR + tPACK, since the packet that retires the write buffer goes between.
#pragma once

#include <cstdint>
#include <vector>

#include "asic/dram/constraint.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::rdram {

using dram::Command;
using dram::Constraint;
using dram::index;
using dram::kCommands;
using dram::kNever;
using dram::kScopes;
using dram::Scope;
using dram::Tcycle;
using dram::to_string;

inline constexpr std::uint32_t kPacket = 4;  // tPACK: a packet of ROW, COL or DQ (Siemens HYB25x144180C)

// Pairs between which the model can hold a constraint; a table may have no others.
constexpr bool honoured(Scope scope, Command from, Command to) {
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

class Timing : public dram::ConstraintTable {
 public:
  explicit Timing(const v1::RdramConfig& config);
  // Throws std::invalid_argument if a row names a pair that is not honoured().
  explicit Timing(std::vector<Constraint> rows);
};

}  // namespace gicube::emu::rdram
