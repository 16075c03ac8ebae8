// An error of the board's RDRAM.
#pragma once

#include <cstdint>

namespace gicube::emu {

// A bit error. `block` counts the blocks that are stored, `bit` the bits of its packed words; both count round.
struct MemoryError {
  std::uint32_t block = 0;
  std::uint32_t bit = 0;
  bool detected = false;
};

}  // namespace gicube::emu
