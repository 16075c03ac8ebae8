// The DSP in a command at cycle level: makes rays and sends them down, takes finished rays back, and keeps overflowed
// rays in its SDRAM until their queue has a slot for them [P §3.1, §3.2].
//
// It does one task at a time, each at its cost (dsp/dsp.h). Returning rays have priority, so the path up always drains;
// then overflowed rays that have a slot; then new rays. Of either kind it sends up to Dsp::kBatch rays, or until the
// path up is full, before it takes returning rays. At most dsp.overflow_rays rays are under way, so that all of them
// fit into the store, and at most as many as their source allows [H324].
#pragma once

#include <algorithm>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <vector>

#include "asic/partition.h"
#include "asic/raybus/ray_bus.h"
#include "asic/sim/fifo.h"
#include "dsp/dsp.h"
#include "dsp/overflow_store.h"
#include "functional/functional_trace.h"
#include "gicube/v1/board_config.pb.h"
#include "levels/ray_source.h"
#include "ray_store.h"
#include "ray_watch.h"

namespace gicube::emu {

struct RayEnginePorts {
  Fifo<RayToken>& down;
  Fifo<RunPool::Run>& runs;
  RunPool& pool;
  Fifo<RayToken>& up;
};

struct RayEngineCounters {
  std::uint64_t sent = 0;       // rays, singly or in runs, including those sent again
  std::uint64_t taken = 0;      // rays that returned finished
  std::uint64_t overflows = 0;  // rays that returned because their queue was full
};

class RayEngine {
 public:
  RayEngine(const v1::BoardConfig& config, const Partition& partition, RayStore& rays, RayWatch& watch,
            const RayEnginePorts& ports);

  // Starts with the rays `which` of `work` at core cycle `now`. `work` and `frame` must outlive the run. `ahead`: the
  // trace of these rays, or null.
  void begin(Cycle now, RaySource& work, const Frame& frame, RayRange which, FunctionalTrace* ahead);
  // Continues a run of a checkpoint. Throws CheckpointFault if it was another one.
  void go_on(RaySource& work, const Frame& frame, RayRange which);

  bool tick(Cycle now);
  // Computes the words of all rays under way; the machine must take their samples from then on.
  void stop_ahead();

  // Whether every ray was made and has returned, and the DSP has finished with the last.
  bool done(Cycle now) const { return made_ == end_ && rays_.under_way() == 0 && !busy(now); }
  // Whether rays are still to be sent, for the first time or again.
  bool has_rays_to_send() const { return made_ < end_ || store_.size() > 0 || outgoing_ != Outgoing::kNothing; }
  // Whether it works beyond the beginning of cycle `now`.
  bool busy(Cycle now) const { return free_at_ * core_khz_ > now * dsp_khz_; }
  // Whether it also waits for its memory.
  bool waits(Cycle now) const { return busy(now) && dsp_.waits(dsp_cycle(now)); }
  // Whether it has nothing to do until a ray returns.
  bool rests() const { return outgoing_ == Outgoing::kNothing && !store_.has_ready() && !may_make(); }
  // Whether no ray is on the ASIC: those under way are kept here, or are about to be sent.
  bool keeps_all_rays() const {
    return rays_.under_way() ==
           store_.size() + (outgoing_ == Outgoing::kRay ? 1 : 0) + (outgoing_ == Outgoing::kRun ? run_.size() : 0);
  }
  // The first core cycle in which the DSP can start a task.
  Cycle free_at() const;

  std::uint64_t finished() const { return finished_; }
  // Rays that the source has made since begin(), and counters of their making.
  std::uint64_t rays_made() const { return rays_made_; }
  const RayCounters& made() const { return making_; }
  const RayEngineCounters& counters() const { return counters_; }
  const Dsp& dsp() const { return dsp_; }
  Dsp& dsp() { return dsp_; }
  // Upper bound of the DSP's clock when the ASIC's clock is at `cycle`.
  DspCycle latest(Cycle cycle) const { return dsp_cycle(cycle) + kMostAhead; }
  // Counters of rays that ended before they were sent, and of_values() of all others.
  const RayCounters& rays() const { return counts_; }
  void add_values(const RayCounters& counters) { counts_ += counters; }
  void dump(std::ostream& out) const;
  void state(Archive& archive) {
    archive.expect_idle(outgoing_ == Outgoing::kNothing, "the DSP");
    const auto clock = [this, &archive](const auto& work) { archive.in_clock(latest(archive.latest()), work); };
    clock([&] { archive("core", dsp_); });
    archive("overflows", store_);
    archive("rays", counts_);
    clock([&] {
      archive.field("engine", [this](Archive::Record& record) {
        record.times(free_at_);
        record(sends_again_, counters_.sent, counters_.taken, counters_.overflows);
      });
    });
    if (archive.in_run()) run_state(archive);
  }

 private:
  void set_out(RaySource& work, const Frame& frame, RayRange which);
  void run_state(Archive& archive);
  DspCycle dsp_cycle(Cycle now) const { return (now * dsp_khz_ + core_khz_ - 1) / core_khz_; }
  void carry_out(Cycle now, const DspTask& task) { free_at_ = dsp_.work(task, std::max(free_at_, dsp_cycle(now))); }
  std::size_t list_of(std::uint8_t processor, std::uint32_t queue) const { return processor * lists_ + queue; }
  bool may_make() const { return made_ < end_ && under_way_ < may_be_under_way_; }
  void take_back(Cycle now);
  // Handles a ray that has ended, is trapped or waits.
  void settle(Cycle now, const RayToken& token);
  // Makes the ray wait for the block in which it is.
  void wait(Cycle now, const RayToken& token, bool is_trapped);
  // Scatters a trapped ray by its routine. kWaits: it waits for the application's answer, or for a block.
  enum class Scattered : std::uint8_t { kSentAgain, kEnds, kWaits };
  Scattered scatter(Cycle now, const RayToken& token);
  enum class Outgoing : std::uint8_t { kNothing, kRay, kRun };

  bool send(Cycle now);
  std::optional<RayToken> make(Cycle now);
  bool computes_ahead() const { return ahead_ != nullptr && !ahead_->has_stopped(); }
  void make_rays(Cycle now);
  void send_again(Cycle now);
  void make_ray(Cycle now);
  void make_run(Cycle now, std::uint64_t last);
  RayToken launch(std::uint32_t handle);
  void report(Cycle now, RayStep step, const RayToken& token, std::uint64_t count = 0) {
    if (token.watched) [[unlikely]]
      watch_.report({.step = step, .cycle = now, .handle = token.ray, .queue = token.queue, .count = count});
  }

  RayStore& rays_;
  RayWatch& watch_;
  RayEnginePorts ports_;
  std::uint64_t core_khz_;
  std::uint64_t dsp_khz_;
  bool single_queue_;
  const Partition& partition_;
  std::size_t lists_;  // lists of overflowed rays per processor
  Dsp dsp_;
  std::size_t slots_;             // slots for overflowed rays
  std::size_t may_be_under_way_;  // rays of the present work
  std::size_t under_way_ = 0;     // rays that were made and have not returned; without carriers
  OverflowStore store_;

  RaySource* work_ = nullptr;
  const Frame* frame_ = nullptr;
  FunctionalTrace* ahead_ = nullptr;              // may have stopped
  std::vector<FunctionalTrace::Ray> rays_ahead_;  // by handle
  std::uint64_t begin_ = 0, end_ = 0;             // range of the work's rays
  std::uint64_t made_ = 0;                        // next ray to make
  std::uint64_t rays_made_ = 0;
  RayCounters making_;
  std::uint64_t finished_ = 0;
  DspCycle free_at_ = 0;
  std::uint32_t batch_ = 0;                 // rays that may still be sent in this batch
  bool sends_again_ = false;                // the batch has overflowed rays
  Outgoing outgoing_ = Outgoing::kNothing;  // is sent when the DSP has finished its task
  RayToken ray_;
  std::vector<RayToken> run_;
  std::vector<std::uint64_t> index_of_;  // by handle: index of the ray in the work
  RayEngineCounters counters_;
  RayCounters counts_;
};

}  // namespace gicube::emu
