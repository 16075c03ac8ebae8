// The DSP as the levels with time see it: it carries out one task after the other, from loops that its program cache holds or that are
// fetched, on data that its data cache holds or that come from the SDRAM.
//
// A change of loop takes the loop's set-up, and its code where that is not in the program cache. The data cache takes a line in when
// something of it is read, and writes it back, if it was changed, when another takes its place. What is only written goes past
// it, byte by byte if need be, through a buffer of four writes. A read holds the DSP up until it is there, a write only if the
// buffer is full.
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
  std::uint64_t compute = 0;  // cycles of loops, and of beginning them
  std::uint64_t waits = 0;    // cycles for the SDRAM: data and code
  std::uint64_t loops = 0;    // changes to another loop
  std::uint64_t hits = 0;     // lines that the data cache had
  std::uint64_t misses = 0;   // and had not
  std::uint64_t code = 0;     // bytes fetched for the program cache

  std::uint64_t busy() const { return compute + waits; }
  void state(Archive::Record& record) { record(compute, waits, loops, hits, misses, code); }
};

class Dsp {
 public:
  // As those of the C6211, the first of the family with caches (TI, SPRS073): 4 KB of code; 4 KB of data, two ways, lines of 32
  // bytes that are taken in by reads alone; four writes wait for the memory.
  static constexpr std::uint32_t kProgramBytes = 4096, kDataBytes = 4096, kLineBytes = sdram::kBurstBytes, kWays = 2;
  static constexpr std::size_t kWrites = 4;
  // Rays that it sends before it looks at what has come, since a change of loop costs about as much as a ray; chosen.
  static constexpr std::uint32_t kBatch = 8;

  explicit Dsp(const v1::BoardConfig& config);

  // Carries a task out from cycle `begin` on, which never decreases; returns the cycle in which it is through.
  DspCycle work(const DspTask& task, DspCycle begin);

  // In the cycles before `until` of its latest task it waited for the SDRAM.
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
  // A loop of a checkpoint, until one of its name comes.
  struct NamedLoop {
    std::string name;
    DspLoop loop;
  };
  void adopt(const DspLoop& loop);
  DspCycle read(std::uint64_t line, DspCycle at);
  DspCycle write(std::uint64_t line, DspCycle at);
  DspCycle touch(std::uint64_t line, SdramUse::Kind kind, DspCycle at);
  DspCycle begin_loop(const DspLoop& loop, DspCycle at);
  DspCycle fetch(const DspLoop& loop, DspCycle at);

  bool ideal_;
  ClockRatio to_memory_, to_dsp_;  // to clocks of the SDRAM, and back
  std::uint64_t memory_clocks_;    // of the SDRAM, at most, that begin in a cycle
  std::uint64_t latency_;          // cycles
  sdram::Channel memory_;
  std::vector<std::array<Line, kWays>> sets_;  // the latest used first
  std::vector<const DspLoop*> program_;        // that the program cache holds, the latest used first
  std::vector<const DspLoop*> linked_;         // in the order in which they were first used: that of their code
  const DspLoop* loop_ = nullptr;
  std::deque<NamedLoop> named_;              // those lists may point at them
  std::array<DspCycle, kWrites> written_{};  // when the last writes left the buffer, the oldest at next_write_
  std::size_t next_write_ = 0;
  DspCycle waited_until_ = 0;
  DspCounters counters_;
};

}  // namespace gicube::emu
