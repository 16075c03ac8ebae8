// Sums over the runs of a level.
#pragma once

#include <vector>

#include "levels/level.h"

namespace gicube::emu {

// Adds counters to those of the same names.
void add_counters(const std::vector<wire::Counter>& from, std::vector<wire::Counter>& to);

// Adds what one run of the ASIC took to that of a command. `core_khz`: of the ASIC's clock.
void add_run(RunResult& to, const RunResult& run, std::uint64_t core_khz);

}  // namespace gicube::emu
