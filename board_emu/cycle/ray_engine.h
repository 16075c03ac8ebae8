// The DSP's part in a command at cycle level: it makes rays and sends them down, takes finished rays back, and keeps
// overflowed rays in its SDRAM until it sends them again [P §3.1, §3.2].
//
// One thing at a time, each at its cost in DSP cycles. What comes back goes first, so the way up always drains; then new
// rays; then overflowed rays, oldest first (chosen: a queue that was full has had time to empty).
#pragma once

#include <cstdint>
#include <deque>
#include <iosfwd>
#include <optional>
#include <vector>

#include "asic/partition.h"
#include "asic/raybus/ray_bus.h"
#include "asic/sim/fifo.h"
#include "gicube/v1/board_config.pb.h"
#include "levels/ray_source.h"
#include "ray_store.h"

namespace gicube::emu {

struct RayEnginePorts {
  Fifo<RayToken>& down;
  Fifo<RunPool::Run>& runs;
  RunPool& pool;
  Fifo<RayToken>& up;
};

struct RayEngineCounters {
  std::uint64_t sent = 0;         // rays, alone or in runs, those sent again included
  std::uint64_t taken = 0;        // rays that came back finished
  std::uint64_t overflows = 0;    // rays that came back since their queue was full
  std::uint64_t busy_cycles = 0;  // of the DSP
};

class RayEngine {
 public:
  RayEngine(const v1::BoardConfig& config, RayStore& rays, const RayEnginePorts& ports);

  // Begins with the rays `which` of `work` at core cycle `now`. `work`, `frame` and `partition` must live until done().
  void begin(Cycle now, RaySource& work, const Frame& frame, const Partition& partition, RayRange which);

  bool tick(Cycle now);

  // Every ray was made and has come back, and the DSP has finished with the last.
  bool done(Cycle now) const { return made_ == end_ && rays_.under_way() == 0 && !busy(now); }
  // Rays are still to be sent for the first time or again.
  bool has_rays_to_send() const { return made_ < end_ || !kept_.empty() || outgoing_ != Outgoing::kNothing; }
  // At work beyond the beginning of cycle `now`.
  bool busy(Cycle now) const { return free_at_ > now * dsp_khz_; }
  // No ray is on the ASIC: those under way are kept here, or on their way out.
  bool keeps_all_rays() const {
    return rays_.under_way() ==
           kept_.size() + (outgoing_ == Outgoing::kRay ? 1 : 0) + (outgoing_ == Outgoing::kRun ? run_.size() : 0);
  }
  // The first core cycle in which the DSP can begin something.
  Cycle free_at() const;

  std::uint64_t finished() const { return finished_; }
  // Rays that the source has made since begin(), and what happened to rays in that.
  std::uint64_t rays_made() const { return rays_made_; }
  const RayCounters& made() const { return making_; }
  const RayEngineCounters& counters() const { return counters_; }
  // Rays that ended before they were sent.
  const RayCounters& rays() const { return counts_; }
  void describe(std::ostream& out) const;

 private:
  void work_for(Cycle now, std::uint64_t dsp_cycles);
  void take_back(Cycle now);
  // Scatters a trapped ray by its routine. kToHost: the application has the ray and must answer.
  enum class Scattered : std::uint8_t { kSentAgain, kEnds, kToHost };
  Scattered scatter(Cycle now, RayToken token);
  enum class Outgoing : std::uint8_t { kNothing, kRay, kRun };

  bool send(Cycle now);
  std::optional<RayToken> make();
  void make_ray(Cycle now);
  void make_run(Cycle now);
  RayToken launch(std::uint32_t handle);

  RayStore& rays_;
  RayEnginePorts ports_;
  std::uint64_t core_khz_;
  std::uint64_t dsp_khz_;
  std::uint32_t overflow_cycles_;
  std::uint32_t run_rays_;
  std::uint32_t run_cycles_;
  bool single_queue_;

  RaySource* work_ = nullptr;
  const Frame* frame_ = nullptr;
  const Partition* partition_ = nullptr;
  std::uint64_t begin_ = 0, end_ = 0;  // of the work's rays
  std::uint64_t made_ = 0;             // up to which
  std::uint64_t rays_made_ = 0;
  RayCounters making_;
  std::uint64_t finished_ = 0;
  // In units of 1 / (core_khz * dsp_khz) ms: a core cycle is dsp_khz of them, a DSP cycle core_khz.
  std::uint64_t free_at_ = 0;
  Outgoing outgoing_ = Outgoing::kNothing;  // leaves when the DSP is through with it
  RayToken ray_;
  std::vector<RayToken> run_;
  std::deque<RayToken> kept_;            // overflowed rays
  std::vector<std::uint64_t> index_of_;  // by handle: which ray of the work it is
  RayEngineCounters counters_;
  RayCounters counts_;
};

}  // namespace gicube::emu
