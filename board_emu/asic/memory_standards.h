// The memory standards that a board can be built with. A new one is a folder beside rdram and ddr and a row here.
#pragma once

#include <cstdint>
#include <memory>

#include "asic/dram/memory.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

// Of the configuration's memory.
dram::Standard memory_standard(const v1::BoardConfig& config);
// One channel with room for `blocks`.
std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks);
// Devices that a channel needs for so many blocks.
std::uint32_t memory_devices_needed(const v1::BoardConfig& config, std::uint32_t blocks);

}  // namespace gicube::emu
