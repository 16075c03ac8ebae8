// The counters of the DSP and of its memory by name.
#pragma once

#include <vector>

#include "dsp/dsp.h"
#include "gicube/wire/counter_list.h"

namespace gicube::emu {

inline void count_dsp(const Dsp& dsp, std::vector<wire::Counter>& list) {
  const DspCounters& core = dsp.counters();
  list.push_back({"dsp.busy_cycles", "DSP cycle", core.busy()});
  list.push_back({"dsp.compute_cycles", "DSP cycle", core.compute});
  list.push_back({"dsp.sdram_wait_cycles", "DSP cycle", core.waits});
  list.push_back({"dsp.loops", "change", core.loops});
  list.push_back({"dsp.cache.hits", "line", core.hits});
  list.push_back({"dsp.cache.misses", "line", core.misses});
  list.push_back({"dsp.program_bytes", "byte", core.code});
  const dram::ChannelCounters memory = dsp.memory().counters();
  list.push_back({"sdram.reads", "packet", memory.packets_read});
  list.push_back({"sdram.writes", "packet", memory.packets_written});
  list.push_back({"sdram.row_hits", "packet", memory.row_hits});
  list.push_back({"sdram.row_misses", "packet", memory.row_misses});
  list.push_back({"sdram.row_conflicts", "packet", memory.conflicts});
  list.push_back({"sdram.data_busy", "clock", memory.dq_busy});
}

}  // namespace gicube::emu
