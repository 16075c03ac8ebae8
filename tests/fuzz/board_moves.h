// Transactions for the fuzzers of the board and of its bus: any bytes, but mostly such as get past the first check.
#pragma once

#include "gicube/wire/frame.h"
#include "input.h"

namespace gicube::fuzz {

struct Move {
  wire::FrameHeader header;  // time_ps 0: the host's clock
  std::vector<std::uint8_t> payload;
};

// A request of a host, with this id. Costs at least one byte of the input.
Move next_move(Input& input, std::uint32_t id);

// A volume, its tables, a picture, rays, light: what a board is asked for to show that it works. Times are 0.
std::vector<Move> known_moves();

}  // namespace gicube::fuzz
