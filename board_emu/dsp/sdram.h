// The DSP's memory: one channel of PC100 SDRAM with 64 data wires. A burst of four clocks is a ray of 32 bytes.
#pragma once

#include <cstdint>

#include "asic/dram/ranks.h"
#include "words/sdram_map.h"

namespace gicube::emu::sdram {

using dram::Access, dram::IssuedCommand, dram::Location, dram::Tcycle;

inline constexpr std::uint32_t kBurst = 4;  // clocks, one beat each
inline constexpr std::uint32_t kBurstBytes = 32;

// A rank has eight chips of 64 Mbit, each of 4 banks, 4096 rows and 512 columns of 8 bits.
inline constexpr std::uint32_t kBanks = 4, kRows = 4096, kBurstsOfRow = 512 / kBurst;
static_assert(std::uint64_t{kBanks} * kRows * kBurstsOfRow * kBurstBytes == sdram_map::kRankBytes);

// A clock is tCK = 10 ns. WR comes with its first beat; tWR counts from the clock of the last one.
// docs/reference/hardware.md has the source of each time.
struct Rules : dram::RankRules {
  static constexpr const char *kName = "sdram", *kDevices = "ranks";
  static constexpr Tcycle kPacket = kBurst;
  static constexpr std::uint32_t kWriteLatency = 0, kRecoveryStart = kBurst - 1;
};

using Channel = dram::RankChannel<Rules>;

// The address of a byte. Consecutive bytes fill the bursts of a row, then the next bank, which can be opened meanwhile.
constexpr Location locate(std::uint64_t byte) {
  const std::uint64_t burst = byte / kBurstBytes, page = burst / kBurstsOfRow, row = page / kBanks;
  return {.device = static_cast<std::uint16_t>(row / kRows),
          .row = static_cast<std::uint16_t>(row % kRows),
          .bank = static_cast<std::uint8_t>(page % kBanks),
          .column = static_cast<std::uint16_t>(burst % kBurstsOfRow)};
}

}  // namespace gicube::emu::sdram
