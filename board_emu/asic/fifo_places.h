// The capacity of the FIFOs that join the parts of the ASIC.
#pragma once

#include <cstddef>

namespace gicube::emu {

inline constexpr std::size_t kFifoPlaces = 2;  // items in each FIFO between two parts

}  // namespace gicube::emu
