// Latencies between the parts of the ASIC, and the capacity of the FIFOs that join them.
#pragma once

#include <cstddef>

#include "words/clock.h"

namespace gicube::emu {

inline constexpr std::size_t kFifoPlaces = 2;  // items in each FIFO between two parts

inline constexpr Cycle kFifoCycles = 1;    // from a push to the first possible pop
inline constexpr Cycle kSorterCycles = 1;  // from being written into a queue to being issued

// To the tag check at the pipeline's beginning:
inline constexpr Cycle kSorterToPipeline = kSorterCycles + kFifoCycles;        // from being written into a queue
inline constexpr Cycle kPipelineToPipeline = kFifoCycles + kSorterToPipeline;  // from the pipeline's end
inline constexpr Cycle kLinkToPipeline = kFifoCycles + kSorterToPipeline;      // from the last link
inline constexpr Cycle kDspToPipeline = 2 * kFifoCycles + kSorterToPipeline;   // over the ray bus

}  // namespace gicube::emu
