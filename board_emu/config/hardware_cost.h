// Computes the on-chip memories of Table 1 of the paper for any configuration. logic_cost.h estimates the transistors.
//
// Units as in the paper: Kb = 2^10 bit, Mb = 2^20 bit [H201-H205].
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "config/logic_cost.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

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
  std::vector<LogicItem> logic;
};

// Fields that are not set count with their defaults.
HardwareCost hardware_cost(const v1::BoardConfig& config);

// One item per line: its formula, bits, and Kb or Mb.
std::string to_string(const HardwareCost& cost);

// For example "4.9 Mb", "9.1 Kb": rounded half up to a tenth; Kb below 1 Mb.
std::string paper_units(std::uint64_t bits);

}  // namespace gicube::emu
