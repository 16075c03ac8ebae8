// One channel of DDR SDRAM (asic/dram/ranks.h).
#pragma once

#include <cstdint>
#include <vector>

#include "asic/dram/ranks.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::ddr {

using dram::Access, dram::BankAddress, dram::ChannelCounters, dram::Command, dram::Constraint, dram::Delay,
    dram::IssuedCommand, dram::kClosed, dram::kNever, dram::Location, dram::Scope, dram::Tcycle;

inline constexpr std::uint32_t kBurst = 1;         // clocks of a burst of two beats
inline constexpr std::uint32_t kWriteLatency = 1;  // WR to data
inline constexpr std::uint32_t kRankSwitch = 1;    // clocks between the data of two ranks, for the strobes [C]

struct Rules : dram::RankRules {
  static constexpr const char *kName = "ddr", *kDevice = "DDR rank", *kDevices = "ranks";
  static constexpr Tcycle kPacket = kBurst;
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

class Channel : public dram::RankChannel<Rules> {
 public:
  // `ranks` from 1 on. Throws std::invalid_argument for 0.
  Channel(const v1::DdrConfig& config, std::uint32_t ranks)
      : dram::RankChannel<Rules>(Timing(config), ranks, config.refresh_interval()) {}
};

}  // namespace gicube::emu::ddr
