// Completion times of boards whose transfers share a bus.
#pragma once

#include <span>
#include <vector>

#include "gicube/time.h"

namespace gicube {

// A part of a board's work, as if the board had the bus alone. Its transfers occupy the bus for `busy` of the `elapsed`
// time, spread evenly.
struct BusPhase {
  Picoseconds elapsed = 0;
  Picoseconds busy = 0;  // at most `elapsed`
};

// The times at which boards finish that begin at time 0 and execute their phases in order. While the boards together
// ask for more than the whole bus, it is divided fairly [PCI 2.2, 3.4]: boards that ask for less than an equal share
// get it, and the others share the rest equally. A board that gets half of what it asks for runs at half its speed.
std::vector<Picoseconds> done_on_shared_bus(std::span<const std::vector<BusPhase>> boards);

}  // namespace gicube
