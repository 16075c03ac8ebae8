// The on-chip memories of Table 1 of the paper, by arithmetic from any configuration; its transistors, by logic_cost.h.
//
// The paper's units: Kb = 2^10 bit, Mb = 2^20 bit.
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
  CostItem volume_cache;  // words; Table 1 leaves its tags out
  CostItem gradient_lut;
  CostItem registers;  // of one processor: Table 1 has no factor of p here
  CostItem segmentation_lut;
  CostItem reflectance_map;
  CostItem sram;                          // all, with the registers of every processor
  std::string memory_signals;             // of one memory channel, by kind
  std::uint32_t memory_signal_count = 0;  // of one memory channel: pins of the ASIC
  std::uint32_t memory_channels = 0;
  std::vector<LogicItem> logic;
};

// Fields that are not set count with their defaults.
HardwareCost hardware_cost(const v1::BoardConfig& config);

// One item a line: its formula, bits, and Kb or Mb.
std::string to_string(const HardwareCost& cost);

// "4.9 Mb", "9.1 Kb": rounded half up to a tenth, Kb below 1 Mb.
std::string paper_units(std::uint64_t bits);

}  // namespace gicube::emu
