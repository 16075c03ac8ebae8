// DDR SDRAM as a memory standard of the board.
#pragma once

#include <cstdint>
#include <memory>

#include "asic/dram/memory.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::ddr {

dram::Standard standard(const v1::BoardConfig& config);
std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks);
std::uint32_t devices_needed(const v1::BoardConfig& config, std::uint32_t blocks);

}  // namespace gicube::emu::ddr
