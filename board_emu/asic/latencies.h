// Cycles between the parts of the ASIC, and the places of the FIFOs that join them: what both timed levels are built from.
#pragma once

#include <cstddef>

#include "words/clock.h"

namespace gicube::emu {

inline constexpr std::size_t kFifoPlaces = 2;  // of each FIFO between two parts

inline constexpr Cycle kFifoCycles = 1;    // what was pushed can be popped a cycle later
inline constexpr Cycle kSorterCycles = 1;  // from being written into a queue to being issued

// To the tag check at the pipeline's beginning:
inline constexpr Cycle kSorterToPipeline = kSorterCycles + kFifoCycles;        // from being written into a queue
inline constexpr Cycle kPipelineToPipeline = kFifoCycles + kSorterToPipeline;  // from the pipeline's end
inline constexpr Cycle kLinkToPipeline = kFifoCycles + kSorterToPipeline;      // from the last link
inline constexpr Cycle kDspToPipeline = 2 * kFifoCycles + kSorterToPipeline;   // over the ray bus

}  // namespace gicube::emu
