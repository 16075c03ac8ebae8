// DDR SDRAM's timing as a table of constraints with the data sheets' names.
//
// The part: 128 Mbit chips of 4 banks, 4096 rows and 1024 columns of 8 bits at 100 MHz (DDR-200, PC1600, CL 2). Their times
// are those of Samsung's modules M312L6420 "A0"; docs/reference/hardware.md has the source of each. Nine of them side by side are a rank of 72 data wires, that is 64 and
// the 8 of a module with error correction, which a voxel's 36 bits need. A burst of two beats, the shortest there is, is
// 144 bits in one clock: one packet of four voxels, at the RDRAM's 1.6 GB/s.
//
// Convention: every time is a clock (tCK = 10 ns), and a command's time is the clock in which it is on the wires. WR's data
// begin one clock after it (tDQSS nominal); tWR and tWTR count from the first clock after the last data.
#pragma once

#include <cstdint>
#include <vector>

#include "asic/dram/constraint.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::ddr {

using dram::Command;
using dram::Constraint;
using dram::index;
using dram::kCommands;
using dram::kNever;
using dram::Scope;
using dram::Tcycle;
using dram::to_string;

inline constexpr std::uint32_t kBurst = 1;         // clocks of a burst of two beats
inline constexpr std::uint32_t kWriteLatency = 1;  // WR to data
inline constexpr std::uint32_t kRankSwitch = 1;    // clocks between the data of two ranks, for the strobes [C]

// Pairs between which the model can hold a constraint; a table may have no others. A device is a rank.
constexpr bool honoured(Scope scope, Command from, Command to) {
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

class Timing : public dram::ConstraintTable {
 public:
  explicit Timing(const v1::DdrConfig& config);
  // Throws std::invalid_argument if a row names a pair that is not honoured().
  explicit Timing(std::vector<Constraint> rows);
};

}  // namespace gicube::emu::ddr
