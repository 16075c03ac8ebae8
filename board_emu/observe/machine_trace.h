// Writes what the processors, links and memories do, cycle by cycle, to a trace.
//
// A processor has a track of its active blocks, a track of its pipeline's causes (cause_runs.h) and a counter of waiting
// rays. Counters are sampled every simulated microsecond and written when they change. Memory is bounded: only the slices
// that are still open are kept.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cycle/machine.h"
#include "observe/active_queue.h"
#include "observe/cause_runs.h"
#include "observe/trace_file.h"

namespace gicube::emu {

class MachineTrace : public Observer {
 public:
  // Process numbers of the file; processor i is kProcessor + i.
  static constexpr int kLinks = 4, kMemory = 5, kProcessor = 10;

  explicit MachineTrace(TraceFile& file) : file_(file) {}

  // The next cycle that is seen begins at `at`, on a board of that configuration.
  void begin(Picoseconds at, const v1::BoardConfig& config);
  void see(Cycle now, const Machine& machine) override;
  // Closes what is open: the cycle that was seen last was the last of its command.
  void end();
  // The end of the cycle that was seen last, once it has been seen.
  Picoseconds end_ps() const { return end_ps_; }

 private:
  struct Lane {
    CauseRuns causes;
    ActiveQueue active;
    std::uint32_t queue = 0;  // whose slice is open
    bool open = false;
    Cycle since = 0;
    std::string block;  // its name
    std::uint64_t issued_before = 0;
    std::uint64_t issued = 0;   // rays, so far
    std::uint64_t waiting = 0;  // as shown
  };
  struct Rate {
    std::uint64_t count = 0;
    std::uint64_t shown = 0;
  };

  Picoseconds time(Cycle cycle) const { return begin_ps_ + cycles_to_ps(cycle - begin_cycle_, core_khz_); }
  void first_cycle(Cycle now, const Machine& machine);
  void name_tracks(const Machine& machine);
  void follow_active(std::size_t lane, Cycle now, const Machine& machine);
  void close_active(std::size_t lane, Cycle end);
  void write_cause(std::size_t lane, const CauseSlice& slice);
  std::string block_name(std::size_t lane, std::uint32_t queue, const Machine& machine) const;
  Cycle microsecond() const;
  std::string memory_counter(std::size_t memory) const;
  void sample(const Machine& machine);
  void quiet();

  TraceFile& file_;
  Picoseconds begin_ps_ = 0;
  Picoseconds end_ps_ = 0;
  std::uint64_t core_khz_ = 1;
  bool single_queue_ = false;
  std::string memory_label_;
  Cycle begin_cycle_ = 0;
  Cycle next_ = 0;  // after the one seen last
  Cycle next_sample_ = 0;
  bool seen_ = false;  // a cycle since begin()
  std::vector<Lane> lanes_;
  std::vector<Rate> packets_;  // by memory
  std::uint64_t on_links_ = 0;
  std::size_t named_lanes_ = 0;
};

}  // namespace gicube::emu
