// The machine's counters by name, for the host and for reports: per processor and memory, and sums over them; and the
// machine's state at one moment.
#pragma once

#include <vector>

#include "gicube/wire/counter_list.h"
#include "machine.h"

namespace gicube::emu {

RayCounters ray_counters(const Machine& machine);
void count(const Machine& machine, std::vector<wire::Counter>& list);
MachineLook look(const Machine& machine);

}  // namespace gicube::emu
