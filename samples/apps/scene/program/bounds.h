// The bottleneck of a run on a board, found from its counters.
#pragma once

#include <cstddef>
#include <string>

#include "gicube/board.h"

namespace gicube::samples {

// One sentence without a full stop, as "bounded by the pipelines: 71% of their cycles take samples, 14% wait for the
// cache; bus 12%, ASIC 88% of the time". `counters`: of a window of `whole` simulated picoseconds, on one board or the
// sum over several. Empty if no time has passed. At the functional level only bus and DSP have time.
std::string what_bounds(Picoseconds whole, const Counters& counters, const BoardInfo& board, std::size_t boards = 1);

}  // namespace gicube::samples
