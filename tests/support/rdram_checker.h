// Holds a trace of RDRAM commands against the data book's rules, one by one. Slow and plain; shares no code and no
// numbers with the memory model that makes the traces.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "asic/rdram/channel.h"

namespace gicube::reference {

// tCYCLE, from a packet's end to another packet's end as the data book counts, DQ at its begin.
struct RdramRules {
  std::uint64_t ras = 20, rp = 8, rr = 8, pp = 8, rcd = 7, cac = 8, cwd = 6, rtr = 8, offp = 4, packet = 4;
  std::uint64_t refresh_interval = 0;  // of each device; 0 = refreshes are not checked
  std::uint64_t refresh_slack = 1000;  // how late a refresh may be
  std::uint32_t devices = 1;
};

struct RdramVerdict {
  std::vector<std::string> faults;         // "tRCD: RD of device 0 bank 3 at 1006"; the first word is the rule
  std::vector<std::uint64_t> data_begins;  // of each RD and WR, in the order of their packets
  std::uint64_t tight_commands = 0;        // that were shown to be impossible one tCYCLE earlier
};

// `trace` in any order. Commands that claim to be tight and are possible one tCYCLE earlier are faults of rule "tight".
RdramVerdict check_rdram_trace(const RdramRules& rules, std::vector<emu::rdram::IssuedCommand> trace);

}  // namespace gicube::reference
