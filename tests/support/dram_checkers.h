// Hold a trace of memory commands against the data sheets' rules, one by one. Slow and plain; they share no code and no
// numbers with the memory models that make the traces.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "asic/dram/memory.h"

namespace gicube::reference {

// Times of SDRAM ranks of single or double data rate, in nanoseconds or clocks as the data sheets of DDR-200 parts have
// them. wr counts from the data's end.
struct RankRules {
  std::uint64_t tck = 10;                                                           // ns
  std::uint64_t ras = 50, rc = 70, rp = 20, rrd = 15, rcd = 20, wr = 15, rfc = 80;  // ns
  std::uint64_t cl = 2, wl = 1, wtr = 1;                                            // clocks
  std::uint64_t burst = 1;                                                          // clocks of the data
  std::uint64_t rank_switch = 1;       // clocks between the data of two ranks, of which one reads
  std::uint64_t refresh_interval = 0;  // clocks, of each rank; 0 = refreshes are not checked
  std::uint64_t refresh_slack = 250;   // how late a refresh may be: 32 packets of one bank, asked for before it
  std::uint32_t devices = 1;           // ranks
};

// Times of RDRAM devices in tCYCLE, from the end of one packet to the end of another; DQ packets count at their begin.
struct RdramRules {
  std::uint64_t ras = 20, rp = 8, rr = 8, pp = 8, rcd = 7, cac = 8, cwd = 6, rtr = 8, offp = 4, packet = 4;
  std::uint64_t refresh_interval = 0;  // of each device; 0 = refreshes are not checked
  std::uint64_t refresh_slack = 1000;  // how late a refresh may be
  std::uint32_t devices = 1;
};

struct TraceVerdict {
  std::vector<std::string> faults;         // "tRCD: RD of device 0 bank 3 at 1006"; the first word is the rule
  std::vector<std::uint64_t> data_begins;  // of each RD and WR, in the order of their commands
  std::uint64_t tight_commands = 0;        // that were shown to be impossible one clock earlier
};

// `trace` in any order. Commands that claim to be tight and are possible one clock earlier are faults of rule "tight".
TraceVerdict check_trace(const RankRules& rules, std::vector<emu::dram::IssuedCommand> trace);
TraceVerdict check_trace(const RdramRules& rules, std::vector<emu::dram::IssuedCommand> trace);

}  // namespace gicube::reference
