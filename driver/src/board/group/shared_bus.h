// When boards are done whose transfers share a bus.
#pragma once

#include <span>
#include <vector>

#include "gicube/time.h"

namespace gicube {

// A part of a board's work, as it would go if the board were alone: in so much time its transfers take the bus for so
// much of it, spread evenly.
struct BusPhase {
  Picoseconds elapsed = 0;
  Picoseconds busy = 0;  // at most `elapsed`
};

// The times at which boards finish that begin at time 0 and execute their phases in order. While the boards together
// ask for more than the whole bus, it serves the waiting ones in turn, so that none gets more than another that wants
// more [PCI 2.2, 3.4: fair arbitration]; a board that gets half of what it asks for continues at half its speed.
std::vector<Picoseconds> done_on_shared_bus(std::span<const std::vector<BusPhase>> boards);

}  // namespace gicube
