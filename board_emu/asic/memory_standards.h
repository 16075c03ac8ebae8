// The memory standards that a board can be built with. A new one is a folder beside rdram and ddr, and its row in
// memory_standards.cpp.
#pragma once

#include <cstdint>
#include <memory>

#include "asic/dram/memory.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

// Of the configuration's memory.
dram::Standard memory_standard(const v1::BoardConfig& config);
// One channel with room for `blocks`, with as many devices as they need.
std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks);

}  // namespace gicube::emu
