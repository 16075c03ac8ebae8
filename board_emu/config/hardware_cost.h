// Computes the on-chip memories of Table 1 of the paper for any configuration. Units as in the paper: Kb = 2^10 bit,
// Mb = 2^20 bit [H201-H205]. Estimates the transistors of the ASIC's logic by counting its components, as a check on
// the paper's estimates.
//
// Static CMOS [C]: an SRAM bit has 6 transistors, a full adder 28 [Weste and Eshraghian, Principles of CMOS VLSI
// Design, 1993], an AND gate 6, a register bit 24, a 2:1 multiplexer 12, a ROM bit 1. A multiplier of a by b bits has a
// b pairs of AND gate and full adder. A divider has a full adder and a multiplexer for each bit of quotient and
// divisor. The word widths are those of the paper's datapath.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

struct LogicItem {
  const char* part = "";  // row of Table 1: Queues, Volume cache, Pipeline, Control
  const char* name = "";
  std::uint64_t count = 0;
  std::uint64_t each = 0;  // transistors

  std::uint64_t transistors() const { return count * each; }
};

struct CostItem {
  std::string formula;
  std::uint64_t bits = 0;
};

struct HardwareCost {
  CostItem ray_queues;    // eDRAM; the others are SRAM
  CostItem volume_cache;  // words; without tags, as in Table 1
  CostItem gradient_lut;
  CostItem registers;  // per processor: Table 1 has no factor of p here
  CostItem segmentation_lut;
  CostItem reflectance_map;
  CostItem sram;                          // total, including the registers of all processors
  std::string memory_signals;             // signals of one memory channel, by kind
  std::uint32_t memory_signal_count = 0;  // ASIC pins of one memory channel
  std::uint32_t memory_channels = 0;
  std::vector<LogicItem> logic;  // items of the same part are adjacent
};

// Fields that are not set count with their defaults.
HardwareCost hardware_cost(const v1::BoardConfig& config);

// One item per line: its formula, bits, and Kb or Mb.
std::string to_string(const HardwareCost& cost);

// For example "4.9 Mb", "9.1 Kb": rounded half up to a tenth; Kb below 1 Mb.
std::string paper_units(std::uint64_t bits);

}  // namespace gicube::emu
