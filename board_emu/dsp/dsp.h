// The timing model of the DSP: it executes one task after the other, with code from the program cache or the SDRAM, on
// data from the data cache or the SDRAM [H1201-H1203].
//
// A change of loop costs the loop's set-up, and a fetch if its code is not in the program cache. The data cache
// allocates a line on reads and writes a changed line back on eviction. A write that misses bypasses the cache through
// a buffer of four writes. A read stalls the DSP until the data arrive, a write only if the buffer is full.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "dsp/sdram.h"
#include "gicube/archive.h"
#include "gicube/v1/board_config.pb.h"
#include "levels/dsp_task.h"
#include "words/clock.h"

namespace gicube::emu {

using DspCycle = std::uint64_t;

struct DspCounters {
  std::uint64_t compute = 0;  // cycles of loops and of their set-up
  std::uint64_t waits = 0;    // cycles for the SDRAM: data and code
  std::uint64_t loops = 0;    // changes to another loop
  std::uint64_t hits = 0;     // accesses to lines in the data cache
  std::uint64_t misses = 0;   // accesses to other lines
  std::uint64_t code = 0;     // bytes fetched for the program cache

  std::uint64_t busy() const { return compute + waits; }
  void state(Archive::Record& record) { record(compute, waits, loops, hits, misses, code); }
};

class Dsp {
 public:
  // The caches of the C6211, the first of its family with caches (TI, SPRS073): 4 KB of code; 4 KB of data in two ways,
  // with lines of 32 bytes, allocated on reads only; a buffer of four writes.
  static constexpr std::uint32_t kProgramBytes = 4096, kDataBytes = 4096, kLineBytes = sdram::kBurstBytes, kWays = 2;
  static constexpr std::size_t kWrites = 4;
  // Rays that it sends before it checks for arrivals. chosen: a change of loop costs about as much as a ray.
  static constexpr std::uint32_t kBatch = 8;

  explicit Dsp(const v1::BoardConfig& config);

  // Executes a task from cycle `begin` on, which never decreases. Returns the cycle in which the task ends.
  DspCycle work(const DspTask& task, DspCycle begin);

  // Whether the latest task waits for the SDRAM at `at`.
  bool waits(DspCycle at) const { return at < waited_until_; }
  const DspCounters& counters() const { return counters_; }
  const sdram::Channel& memory() const { return memory_; }
  sdram::Channel& memory() { return memory_; }
  void state(Archive& archive);

 private:
  struct Line {
    std::uint64_t number = ~std::uint64_t{0};
    bool changed = false;

    void state(Archive::Record& record) { record(number, changed); }
  };
  // A loop from a checkpoint.
  struct NamedLoop {
    std::string name;
    DspLoop loop;
  };
  DspCycle read(std::uint64_t line, DspCycle at);
  DspCycle write(std::uint64_t line, DspCycle at);
  DspCycle access_line(std::uint64_t line, SdramUse::Kind kind, DspCycle at);
  DspCycle begin_loop(const DspLoop& loop, DspCycle at);
  DspCycle fetch(const DspLoop& loop, DspCycle at);

  bool ideal_;
  ClockRatio to_memory_, to_dsp_;  // to clocks of the SDRAM and back
  std::uint64_t memory_clocks_;    // the most clocks of the SDRAM that begin in one cycle
  std::uint64_t latency_;          // cycles
  sdram::Channel memory_;
  std::vector<std::array<Line, kWays>> sets_;  // the most recently used first
  std::vector<const DspLoop*> program_;        // loops in the program cache, the most recently used first
  std::vector<const DspLoop*> linked_;         // in the order of their first use, which is that of their code
  const DspLoop* loop_ = nullptr;
  std::deque<NamedLoop> named_;              // the lists above may point to them
  std::array<DspCycle, kWrites> written_{};  // when the last writes left the buffer, the oldest at next_write_
  std::size_t next_write_ = 0;
  DspCycle waited_until_ = 0;
  DspCounters counters_;
};

}  // namespace gicube::emu
