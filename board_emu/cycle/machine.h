// The whole board at cycle level: DSP, ray bus, processors, links, merge tree and memories, and the clock that ticks
// them.
//
// All parts are connected by registered FIFOs, so the order in which they tick within a cycle does not matter. Time and
// the contents of the caches persist from command to command. Cycles in which the ASIC is empty and the DSP works are
// counted without ticking.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <vector>

#include "asic/fifo_places.h"
#include "asic/link/ring.h"
#include "asic/partition.h"
#include "asic/raybus/merge_tree.h"
#include "asic/raybus/ray_bus.h"
#include "levels/level.h"
#include "lookahead.h"
#include "memory_port.h"
#include "observer.h"
#include "processor.h"
#include "ray_engine.h"
#include "ray_store.h"
#include "ray_watch.h"

namespace gicube::emu {

class Machine {
 public:
  static constexpr Cycle kStallCycles = 100'000;  // chosen: far above any latency of a part

  // For volumes of `blocks` blocks along x, y, z.
  Machine(const v1::BoardConfig& config, const std::array<int, 3>& blocks);

  // Traces the rays `which` of `work` to their ends. Progress is in rays that have returned. The result has the
  // counters of making rays; all others are in machine_counters.h. Throws Stall, and RoutineFault. `ahead`: null, or
  // the trace of these rays, whose values the policy must not read.
  RunResult run(RaySource& work, const Frame& frame, Progress& progress, RayRange which,
                FunctionalTrace* ahead = nullptr);
  // Continues the run of a checkpoint with the same source. Throws CheckpointFault if it was another one.
  RunResult go_on(RaySource& work, const Frame& frame, Progress& progress, RayRange which);
  RunResult run(RaySource& work, const Frame& frame, Progress& progress) {
    return run(work, frame, progress, {0, work.count()});
  }

  // To be called when the volume's words have changed.
  void invalidate_caches();

  // Only between runs. The observer must outlive the machine, or be replaced. Null: none.
  void set_observer(Observer* observer) { observer_ = observer; }
  // Whether the next run would be observed from its start.
  bool has_interested_observer() const { return observer_ != nullptr && observer_->is_interested(); }
  // For tests: parts tick in a random order, a different one in each cycle. No result may depend on it.
  void shuffle_ticks(std::uint64_t seed) { shuffle_ = seed; }

  Cycle now() const { return now_; }
  const std::array<int, 3>& blocks() const { return blocks_; }
  bool has_single_queue() const { return config_.sorter().queues() == v1::single; }
  const Partition& partition() const { return partition_; }
  const std::vector<std::unique_ptr<Processor>>& processors() const { return processors_; }
  const std::vector<std::unique_ptr<MemoryPort>>& memories() const { return memories_; }
  const RayEngine& dsp() const { return *dsp_; }
  const RayStore& rays() const { return rays_; }
  RayStore& rays() { return rays_; }
  // Dumps the state of all parts, in one or more lines each.
  void dump(std::ostream& out) const;
  const RayBus& ray_bus() const { return *ray_bus_; }
  struct Millisecond {
    std::uint64_t activations = 0;  // activations of queues
    std::uint64_t samples = 0;

    void state(Archive::Record& record) { record(activations, samples); }
  };
  // Processor cycles that were computed by inner loops, many at a time, because nobody observed them.
  std::uint64_t cycles_ahead() const { return lookahead_.cycles_ahead(); }
  // Work in each simulated millisecond. The last entry is for all later ones.
  const std::vector<Millisecond>& milliseconds() const { return milliseconds_; }
  const dram::Standard& memory_standard() const { return standard_; }
  const Ring& links() const { return *links_; }
  // FIFOs between the DSP and the ASIC.
  const Fifo<RayToken>& down() const { return down_; }
  const Fifo<RunPool::Run>& runs() const { return runs_; }
  const Fifo<RayToken>& up() const { return up_; }

  // Between two runs no ray is under way, so FIFOs, queues and stages are empty. During a run it may be called from
  // Observer::see() and Progress::may_count().
  void state(Archive& archive);

 private:
  // State of a run, in addition to that of the parts.
  struct Run {
    Cycle begin = 0;
    std::uint64_t dsp_before = 0;  // cycles in which it had worked before
    Cycle moved_at = 0;            // the last cycle in which something moved
    Cycle report_at = 0;
    Cycle skips_to = 0;  // cycles before this one are only counted, by
    Cause skip_cause = Cause::kDsp;

    void state(Archive::Record& record) {
      record.times(begin);
      record(dsp_before);
      record.times(moved_at, report_at);
      record(skips_to);
      record.at_most(skip_cause, Cause::kSdram);
    }
  };

  void set_out(const Frame& frame, bool has_trace);
  // Has the rest of the run observed: parts are ticked in every cycle, and rays have their words.
  void be_observed();
  // Computes the words of rays under way.
  void take_samples();
  RunResult to_the_end(Progress& progress, RayRange which);
  void run_state(Archive& archive, TokenLimits& limits);
  bool tick();
  bool tick_shuffled();
  bool tick_part(std::size_t part);
  void skip();
  // The next cycle in which more happens than that processors run ahead and the DSP works.
  Cycle next_cycle() const;
  // Shows the cycle to the observer, if it has requested that.
  void show() {
    if (now_ < see_at_) [[likely]]
      return;
    is_seen_ = true;
    observer_->see(now_, *this);
    is_seen_ = false;
    ask_observer(now_ + 1);
  }
  void ask_observer(Cycle from) { see_at_ = is_observed_ ? std::max(from, observer_->next(from)) : kNoCycle; }
  bool is_seen_soon() const { return see_at_ - now_ <= kSeenSoon; }
  // No ray is on the ASIC, and no changed irradiance waits for the memory.
  bool asic_idle() const;
  Cause upstream();
  bool some_hold_rays();
  // Books the stall causes of a sleeping processor. Needed only when a ray arrives or its counters must be consistent.
  void wake(std::size_t processor);
  void wake_all() {
    for (std::size_t i = 0; i < processors_.size(); ++i) wake(i);
    upstream_.clear();
  }
  void book_millisecond();
  void collect_values();
  [[noreturn]] void stalled() const;

  v1::BoardConfig config_;
  std::array<int, 3> blocks_;
  Partition partition_;
  dram::Standard standard_;
  RayStore rays_;
  Cycle see_at_ = kNoCycle;  // the next cycle that the observer has requested
  RayWatch watch_{*this, rays_, see_at_};
  Fifo<RayToken> down_{kFifoPlaces};
  Fifo<RunPool::Run> runs_{kFifoPlaces};
  RunPool run_pool_;
  Fifo<RayToken> up_{kFifoPlaces};
  std::vector<std::unique_ptr<Processor>> processors_;
  std::vector<std::unique_ptr<MemoryPort>> memories_;
  std::unique_ptr<RayBus> ray_bus_;
  std::unique_ptr<Ring> links_;
  std::unique_ptr<MergeTree> tree_;
  std::unique_ptr<RayEngine> dsp_;
  // This close to an observed cycle, requests are not sent ahead. Chosen: far above the delay of a memory's queued
  // requests.
  static constexpr Cycle kSeenSoon = 4096;
  Observer* observer_ = nullptr;
  bool is_observed_ = false;   // the rest of the run is observed
  std::uint64_t shuffle_ = 0;  // 0 = the usual order
  Cycle now_ = 0;
  bool is_seen_ = false;  // the cycle is over, but not counted yet
  Run run_;
  // Unused if the run is observed, if parts tick in a random order, or if two processors share a memory.
  Lookahead lookahead_;
  bool looks_ahead_ = false;
  std::vector<std::size_t> ticked_;  // processors of this cycle
  static constexpr std::size_t kAwake = ~std::size_t{0};
  std::vector<std::size_t> asleep_since_;  // by processor: first entry of `upstream_` that is not booked, or kAwake
  std::size_t asleep_ = 0;                 // number of sleeping processors
  std::vector<Cause> upstream_;            // by cycle since a report, if a processor sleeps
  std::vector<Millisecond> milliseconds_;
  Millisecond booked_;  // the sum of milliseconds_
};

}  // namespace gicube::emu
