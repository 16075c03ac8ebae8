// The ray bus from the DSP to the processors: a broadcast of one 32-byte packet per core cycle [P §3.6].
//
//   down (rays) --+                       +-- run buffer 0 -+-> from_bus 0
//                 +-- one packet a cycle -+       ...       +->    ...
//   runs ---------+                       +-- run buffer p -+-> from_bus p-1
//
// A ray is one packet. It goes to its owner's FIFO and waits at the head if that is full. A run (RunPool) is two
// packets, which all processors receive; each processor then extrapolates its own rays of the run into its FIFO, one
// per cycle. A processor buffers two runs; the bus sends the next run only if every processor has room. Rays and runs
// take turns when both can be sent, and so do a ray and an extrapolated ray for the same FIFO [H315, H316].
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <span>
#include <vector>

#include "asic/sim/fifo.h"
#include "gicube/archive.h"
#include "words/words.h"

namespace gicube::emu {

// Runs of viewing rays, the ray differentials of [P §3.6], on their way to the processors. On the bus a run is two
// packets: its first ray, and the differential and count from which each processor extrapolates its own rays. The model
// keeps the tokens of the run's rays, which the DSP's own arithmetic has made: differentials change times but no bit of
// an image.
class RunPool {
 public:
  using Run = std::uint32_t;  // handle

  explicit RunPool(std::uint32_t listeners) : listeners_(listeners) {}

  // Adds a run of at least one ray. Push the handle into the bus's FIFO of runs.
  Run add(std::span<const RayToken> rays);
  std::span<const RayToken> rays(Run run) const { return runs_[run].rays; }
  // Called once by each listener when it has finished with the run. The last call frees it.
  void release(Run run);
  // By run, the listeners that have not released it.
  std::vector<std::uint32_t> holders() const;
  void state(Archive& archive);
  std::uint32_t in_use() const { return static_cast<std::uint32_t>(runs_.size() - free_.size()); }

 private:
  struct Entry {
    std::vector<RayToken> rays;
    std::uint32_t holders = 0;
  };

  std::uint32_t listeners_;
  std::vector<Entry> runs_;
  std::vector<Run> free_;
};

struct RayBusCounters {
  std::uint64_t rays = 0;      // rays sent as single packets
  std::uint64_t runs = 0;      // sent
  std::uint64_t run_rays = 0;  // extrapolated from runs
  std::uint64_t busy = 0;      // cycles with a packet on the bus
  std::uint64_t waits = 0;     // cycles without a packet although a ray or run was waiting

  void state(Archive::Record& record) { record(rays, runs, run_rays, busy, waits); }
};

class RayBus {
 public:
  static constexpr std::uint32_t kRunBuffers = 2;  // [C] runs per processor

  // `runs` carries handles of `pool`, which has one listener per processor.
  RayBus(Fifo<RayToken>& down, Fifo<RunPool::Run>& runs, RunPool& pool,
         const std::vector<Fifo<RayToken>*>& to_processors);

  bool tick(Cycle now);

  // True if no packet is on the bus and no run is being extrapolated.
  bool idle() const { return !sending_ && extrapolating_ == 0; }
  const RayBusCounters& counters() const { return counters_; }
  void dump(std::ostream& out) const;
  void state(Archive& archive) {
    archive.expect_idle(idle() && !sent_run_ && pool_.in_use() == 0, "the ray bus");
    archive("turns", listeners_);
    archive("run_next", run_next_);
    archive("counters", counters_);
    if (archive.in_run()) runs_state(archive);
  }

 private:
  struct Buffered {
    RunPool::Run run = 0;
    std::uint32_t next = 0;  // next ray of the run to examine
  };
  struct Listener {
    Fifo<RayToken>* fifo = nullptr;
    std::array<Buffered, kRunBuffers> runs;  // the older first
    std::uint32_t count = 0;
    bool run_had_turn = false;

    void state(Archive::Record& record) { record(run_had_turn); }
  };

  void runs_state(Archive& archive);
  bool send(Cycle now);
  bool ray_can_go(Cycle now) const;
  bool run_can_go() const;
  void take_in_run();
  bool extrapolate(Cycle now, std::uint8_t processor);
  // The first of the processor's rays in a run at or after `from`; the run's length if there is none.
  std::uint32_t next_own(RunPool::Run run, std::uint32_t from, std::uint8_t processor) const;

  Fifo<RayToken>& down_;
  Fifo<RunPool::Run>& runs_;
  RunPool& pool_;
  std::vector<Listener> listeners_;
  bool sending_ = false;   // run_'s second packet is next
  bool sent_run_ = false;  // run_ has arrived in this cycle
  RunPool::Run run_ = 0;
  bool run_next_ = false;            // when both can be sent, the run has its turn
  std::uint32_t extrapolating_ = 0;  // runs in all buffers
  RayBusCounters counters_;
};

}  // namespace gicube::emu
