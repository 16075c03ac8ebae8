// What a memory channel says about the packets that it serves, whatever its standard.
#pragma once

#include <cstdint>

#include "asic/dram/constraint.h"

namespace gicube::emu::dram {

// Where a packet lies in a channel's memory.
struct Location {
  std::uint16_t device = 0;
  std::uint16_t row = 0;
  std::uint8_t bank = 0;
  std::uint16_t column = 0;  // packet within the row

  friend constexpr bool operator==(const Location&, const Location&) = default;
};

// What delayed a packet beyond what lay before it on the wires and the ordinary latency of its own commands.
enum class Delay : std::uint8_t {
  kTransfer,  // nothing, or the wires: packets before it and the turnaround
  kBank,      // its bank: other rows, other activations, precharges
  kRefresh,   // a refresh that keeps its row closed, or one just before its activation
};

struct Access {
  Tcycle data_begin = 0;  // on the data wires at the controller
  Tcycle data_end = 0;    // the clock after the last
  Delay cause = Delay::kTransfer;
};

struct IssuedCommand {
  Command command;
  bool tight;  // claimed: not possible one clock earlier
  std::uint16_t device;
  std::uint16_t row;  // of kActivate
  std::uint8_t bank;
  std::uint16_t column;  // of kRead, kWrite
  Tcycle begin;
  Tcycle asked;  // when what it serves arrived: a packet, a refresh that was due
};

struct ChannelCounters {
  std::uint64_t packets_read = 0;
  std::uint64_t packets_written = 0;
  std::uint64_t row_hits = 0;    // packets whose row was open
  std::uint64_t row_misses = 0;  // the others; one activation each
  std::uint64_t conflicts = 0;   // row misses that had to precharge first
  std::uint64_t activates = 0;   // without refreshes
  std::uint64_t precharges = 0;  // those for refreshes too
  std::uint64_t refreshes = 0;
  std::uint64_t dq_busy = 0;     // clocks
  std::uint64_t turnaround = 0;  // clocks that the data wires stood still because the direction changed

  friend bool operator==(const ChannelCounters&, const ChannelCounters&) = default;
};

}  // namespace gicube::emu::dram
