// The memory standards that a board can be built with. A new one is a folder beside rdram and ddr, and its row in
// memory_standards.cpp.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "asic/dram/memory.h"
#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

// The standard that the configuration chooses.
dram::Standard memory_standard(const v1::BoardConfig& config);
// Blocks in memory for `blocks` of the volume. Irradiance in cells takes blocks of its own.
inline std::size_t blocks_in_memory(const v1::BoardConfig& config, std::size_t blocks) {
  return config.cache().irradiance() == v1::in_cells ? 2 * blocks : blocks;
}
// One channel with room for `blocks`. It has as many devices as they need.
std::unique_ptr<dram::Memory> make_memory(const v1::BoardConfig& config, std::uint32_t blocks);

}  // namespace gicube::emu
