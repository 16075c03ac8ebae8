// One channel of DDR SDRAM (asic/dram/ranks.h) [H1501-H1503].
#pragma once

#include "asic/dram/ranks.h"

namespace gicube::emu::ddr {

using dram::Access, dram::ChannelCounters, dram::Command, dram::Constraint, dram::IssuedCommand, dram::kClosed,
    dram::kNever, dram::Location, dram::Scope, dram::Tcycle;

inline constexpr std::uint32_t kBurst = 1;  // clocks of a burst of two beats

// The part: 128 Mbit chips of 4 banks, 4096 rows and 1024 columns of 8 bits at 100 MHz (DDR-200, PC1600, CL 2). Their
// times are those of Samsung's modules M312L6420 "A0"; docs/reference/hardware.md has the source of each. Nine chips
// form a rank of 72 data wires: 64 and the 8 of a module with error correction, which a voxel's 36 bits need. A burst
// of two beats, the shortest, is 144 bits in one clock: one packet of four voxels, at the RDRAM's 1.6 GB/s.
//
// A clock is tCK = 10 ns. WR's data begin one clock after it (tDQSS nominal); tWR and tWTR count from the first clock
// after the last data. The data of two ranks keep a clock apart for the strobes [C].
struct Rules : dram::RankRules {
  static constexpr const char *kName = "ddr", *kDevices = "ranks";
  static constexpr Tcycle kPacket = kBurst;
  static constexpr std::uint32_t kWriteLatency = 1, kRecoveryStart = kWriteLatency + kBurst;
};

using Channel = dram::RankChannel<Rules>;

}  // namespace gicube::emu::ddr
