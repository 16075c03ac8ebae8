// The DSP's memory: one channel of PC100 SDRAM, 64 data wires, in which a burst of four clocks is a ray of 32 bytes.
#pragma once

#include <cstdint>
#include <vector>

#include "asic/dram/ranks.h"
#include "gicube/v1/board_config.pb.h"
#include "words/sdram_map.h"

namespace gicube::emu::sdram {

using dram::Access, dram::BankAddress, dram::Command, dram::Constraint, dram::IssuedCommand, dram::Location,
    dram::Scope, dram::Tcycle;

inline constexpr std::uint32_t kBurst = 4;  // clocks, a beat each
inline constexpr std::uint32_t kBurstBytes = 32;
inline constexpr std::uint32_t kRankSwitch = 1;  // clocks between the data of two ranks [C]

// A rank: eight chips of 64 Mbit, each of 4 banks, 4096 rows and 512 columns of 8 bits.
inline constexpr std::uint32_t kBanks = 4, kRows = 4096, kBurstsOfRow = 512 / kBurst;
static_assert(std::uint64_t{kBanks} * kRows * kBurstsOfRow * kBurstBytes == sdram_map::kRankBytes);

struct Rules : dram::RankRules {
  static constexpr const char *kName = "sdram", *kDevice = "SDRAM rank", *kDevices = "ranks";
  static constexpr Tcycle kPacket = kBurst;
};

using Rank = dram::Device<Rules>;

// SDRAM's timing as a table of constraints with the data sheets' names; docs/reference/hardware.md has the source of each.
//
// Every time is a clock (tCK = 10 ns), and a command's time is the clock in which it is on the wires. WR comes with its first
// beat; tWR counts from the clock of the last one.
class Timing : public dram::ConstraintTable {
 public:
  explicit Timing(const v1::SdramConfig& config);
  // Throws std::invalid_argument if a row names a pair that is not honoured().
  explicit Timing(std::vector<Constraint> rows);
};

class Channel : public dram::RankChannel<Rules> {
 public:
  explicit Channel(const v1::SdramConfig& config)
      : dram::RankChannel<Rules>(Timing(config), config.ranks(), config.refresh_interval()) {}
};

// Where a byte lies: bursts of a row, then the banks, so that what follows on a row is in a bank that can be opened meanwhile.
constexpr Location locate(std::uint64_t byte) {
  const std::uint64_t burst = byte / kBurstBytes, page = burst / kBurstsOfRow, row = page / kBanks;
  return {.device = static_cast<std::uint16_t>(row / kRows),
          .row = static_cast<std::uint16_t>(row % kRows),
          .bank = static_cast<std::uint8_t>(page % kBanks),
          .column = static_cast<std::uint16_t>(burst % kBurstsOfRow)};
}

}  // namespace gicube::emu::sdram
