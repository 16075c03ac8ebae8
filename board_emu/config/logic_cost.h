// Estimates the transistors of the ASIC's logic by counting its components, as a check on the estimates of Table 1 of
// the paper.
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

// Items of the same part are adjacent. Fields that are not set count with their defaults.
std::vector<LogicItem> logic_cost(const v1::BoardConfig& config);

// One item per line, with a sum for each part and a total.
std::string to_string(const std::vector<LogicItem>& items);

}  // namespace gicube::emu
