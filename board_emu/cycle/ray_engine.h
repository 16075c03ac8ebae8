// The DSP's part in a command at cycle level: it makes rays and sends them down, takes finished rays back, and keeps
// overflowed rays in its SDRAM until their queue has a slot for them [P §3.1, §3.2].
//
// One task at a time, each at its cost (dsp/dsp.h). What comes back goes first, so the way up always drains; then overflowed rays
// that have a slot; then new rays. Once it sends either it sends up to Dsp::kBatch of them, or until the way up
// is full, before it looks at what has come. No more rays are under way than dsp.overflow_rays says, so that all of them find a
// place there, and no more than their source allows.
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
#include "gicube/v1/board_config.pb.h"
#include "levels/ray_source.h"
#include "ray_store.h"
#include "ray_watch.h"
#include "values_ahead.h"

namespace gicube::emu {

struct RayEnginePorts {
  Fifo<RayToken>& down;
  Fifo<RunPool::Run>& runs;
  RunPool& pool;
  Fifo<RayToken>& up;
};

struct RayEngineCounters {
  std::uint64_t sent = 0;       // rays, alone or in runs, those sent again included
  std::uint64_t taken = 0;      // rays that came back finished
  std::uint64_t overflows = 0;  // rays that came back since their queue was full
};

class RayEngine {
 public:
  RayEngine(const v1::BoardConfig& config, const Partition& partition, RayStore& rays, RayWatch& watch,
            const RayEnginePorts& ports);

  // Begins with the rays `which` of `work` at core cycle `now`. `work` and `frame` must live until done(). `ahead`: of these rays, or
  // null.
  void begin(Cycle now, RaySource& work, const Frame& frame, RayRange which, ValuesAhead* ahead);
  // Goes on with a run of a checkpoint. Throws CheckpointFault if it was another one.
  void go_on(RaySource& work, const Frame& frame, RayRange which);

  bool tick(Cycle now);
  // Brings the words of all rays under way to where they are; the machine must take their samples from now on.
  void stop_ahead();

  // Every ray was made and has come back, and the DSP has finished with the last.
  bool done(Cycle now) const { return made_ == end_ && rays_.under_way() == 0 && !busy(now); }
  // Rays are still to be sent for the first time or again.
  bool has_rays_to_send() const { return made_ < end_ || store_.size() > 0 || outgoing_ != Outgoing::kNothing; }
  // At work beyond the beginning of cycle `now`.
  bool busy(Cycle now) const { return free_at_ * core_khz_ > now * dsp_khz_; }
  // And waits for its memory.
  bool waits(Cycle now) const { return busy(now) && dsp_.waits(dsp_cycle(now)); }
  // Does nothing until a ray comes back.
  bool rests() const { return outgoing_ == Outgoing::kNothing && !store_.has_ready() && !may_make(); }
  // No ray is on the ASIC: those under way are kept here, or on their way out.
  bool keeps_all_rays() const {
    return rays_.under_way() ==
           store_.size() + (outgoing_ == Outgoing::kRay ? 1 : 0) + (outgoing_ == Outgoing::kRun ? run_.size() : 0);
  }
  // The first core cycle in which the DSP can begin something.
  Cycle free_at() const;

  std::uint64_t finished() const { return finished_; }
  // Rays that the source has made since begin(), and what happened to rays in that.
  std::uint64_t rays_made() const { return rays_made_; }
  const RayCounters& made() const { return making_; }
  const RayEngineCounters& counters() const { return counters_; }
  const Dsp& dsp() const { return dsp_; }
  Dsp& dsp() { return dsp_; }
  // Where its clock can have come when that of the ASIC comes to `cycle`.
  DspCycle latest(Cycle cycle) const { return dsp_cycle(cycle) + kMostAhead; }
  // Rays that ended before they were sent, and of_values() of all others.
  const RayCounters& rays() const { return counts_; }
  void add_values(const RayCounters& counters) { counts_ += counters; }
  void describe(std::ostream& out) const;
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
  void run_state(Archive& archive);
  DspCycle dsp_cycle(Cycle now) const { return (now * dsp_khz_ + core_khz_ - 1) / core_khz_; }
  void carry_out(Cycle now, const DspTask& task) { free_at_ = dsp_.work(task, std::max(free_at_, dsp_cycle(now))); }
  std::size_t list_of(std::uint8_t processor, std::uint32_t queue) const { return processor * lists_ + queue; }
  bool may_make() const { return made_ < end_ && under_way_ < may_be_under_way_; }
  void take_back(Cycle now);
  // What has come to its end, is trapped or waits.
  void settle(Cycle now, const RayToken& token);
  // The ray waits for the block in which it is.
  void wait(Cycle now, const RayToken& token, bool is_trapped);
  // Scatters a trapped ray by its routine. kWaits: the application has it and must answer, or it waits for a block.
  enum class Scattered : std::uint8_t { kSentAgain, kEnds, kWaits };
  Scattered scatter(Cycle now, const RayToken& token);
  enum class Outgoing : std::uint8_t { kNothing, kRay, kRun };

  bool send(Cycle now);
  std::optional<RayToken> make(Cycle now);
  std::optional<wire::Ray> make_ahead(std::uint64_t index, ValuesAhead::Ray& values);
  bool computes_ahead() const { return ahead_ != nullptr && !ahead_->has_stopped(); }
  void make_rays(Cycle now);
  void send_again(Cycle now);
  void make_ray(Cycle now);
  void make_run(Cycle now, std::uint64_t last);
  RayToken launch(std::uint32_t handle);
  void tell(Cycle now, RayStep step, const RayToken& token, std::uint64_t count = 0) {
    if (token.watched) [[unlikely]]
      watch_.tell({.step = step, .cycle = now, .handle = token.ray, .queue = token.queue, .count = count});
  }

  RayStore& rays_;
  RayWatch& watch_;
  RayEnginePorts ports_;
  std::uint64_t core_khz_;
  std::uint64_t dsp_khz_;
  bool single_queue_;
  const Partition& partition_;
  std::size_t lists_;  // of overflowed rays, of a processor
  Dsp dsp_;
  std::size_t places_;            // for overflowed rays
  std::size_t may_be_under_way_;  // rays of the work in hand
  std::size_t under_way_ = 0;     // rays that were made and have not come back; without carriers
  OverflowStore store_;

  RaySource* work_ = nullptr;
  const Frame* frame_ = nullptr;
  ValuesAhead* ahead_ = nullptr;              // may have stopped
  std::vector<ValuesAhead::Ray> rays_ahead_;  // by handle
  std::uint64_t begin_ = 0, end_ = 0;         // of the work's rays
  std::uint64_t made_ = 0;                    // up to which
  std::uint64_t rays_made_ = 0;
  RayCounters making_;
  std::uint64_t finished_ = 0;
  DspCycle free_at_ = 0;
  std::uint32_t batch_ = 0;                 // rays that it may still send
  bool sends_again_ = false;                // those are overflowed ones
  Outgoing outgoing_ = Outgoing::kNothing;  // leaves when the DSP is through with it
  RayToken ray_;
  std::vector<RayToken> run_;
  std::vector<std::uint64_t> index_of_;  // by handle: which ray of the work it is
  RayEngineCounters counters_;
  RayCounters counts_;
};

}  // namespace gicube::emu
