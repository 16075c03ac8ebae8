// The interface between a command and a level: makes rays, and takes traced rays back.
//
// A level takes the rays one by one in their order, like the DSP, or in batches on several threads; never both in one
// run.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "gicube/archive.h"
#include "gicube/wire/ray.h"
#include "levels/dsp_task.h"

namespace gicube::emu {

// A subset of a source's rays, which one thread makes, traces and takes back.
struct RayBatch {
  RayBatch() = default;
  RayBatch(const RayBatch&) = delete;  // `rays` may point into it
  RayBatch& operator=(const RayBatch&) = delete;
  virtual ~RayBatch() = default;

  // Keeps the rays for which `ends(ray)` is true, in their order.
  template <typename Ends>
  void keep_if(const Ends& ends) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < rays.size(); ++k) {
      if (!ends(rays[k])) continue;
      if (kept != k) {
        rays[kept] = rays[k];
        if (!index.empty()) index[kept] = index[k];
      }
      ++kept;
    }
    rays = rays.first(kept);
  }

  std::span<wire::Ray> rays;         // rays that go to the ASIC
  std::vector<wire::Ray> room;       // their storage, unless the source has its own
  std::vector<std::uint64_t> index;  // their indices in the source; empty if the source needs none
  std::uint64_t returned = 0;        // rays that did not go to the ASIC but cost the DSP as much as one that returns
  RayCounters counters;              // events counted while the rays were made
};

// Rays [begin, end) of a source.
struct RayRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

// Most viewing rays under way. Neighbours traverse the same blocks at the same time: with more rays, queues overflow
// more often and nothing is gained [H1205].
inline constexpr std::uint64_t kViewingRaysUnderWay = 8192;

class RaySource {
 public:
  virtual ~RaySource() = default;

  virtual std::uint64_t count() const = 0;

  // DSP cost of making ray `i`, or the run that begins with it, and of taking it back.
  virtual DspTask making(std::uint64_t i) const = 0;
  virtual DspTask taking(std::uint64_t i) const = 0;
  // DSP cost, before taking(), of the search for a lamp that a ray hits after it has left the volume.
  virtual DspTask looking(const wire::Ray&) const { return {}; }
  // DSP cycles to make `made` and take `taken` rays, if their order is unknown: each loop is started once, without
  // waiting.
  virtual std::uint64_t dsp_cycles(std::uint64_t made, std::uint64_t taken) const;
  // Whether rays that are not made cost nothing, because the DSP skips whole faces that the light does not reach.
  virtual bool misses_are_free() const { return false; }
  // The DSP makes rays i .. run_end(i) - 1 as one run, which is sent as a differential [P §3.6].
  virtual std::uint64_t run_end(std::uint64_t i) const { return i + 1; }
  // Number of rays that the DSP's memory holds between two runs of the ASIC; the cycle level traces that many per run.
  virtual std::uint64_t max_at_once() const { return count(); }
  // Most rays of this source under way, if the overflow store has room for them.
  virtual std::uint64_t max_under_way() const { return count(); }

  // Makes ray `i`; called once for each. Returns nothing for a ray that does not go to the ASIC: the source has
  // completed it and counted it in `counters`.
  virtual std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) = 0;
  // Takes traced ray `i` back, whose flags are undefined. Called once for each ray that was made, unless it waits for
  // the host.
  virtual void take(std::uint64_t i, const wire::Ray& ray) = 0;

  // Saves or restores what rays of the run beginning with ray `begin` have left in the source so far.
  virtual void state(Archive::Record& /*record*/, std::uint64_t /*begin*/) {}

  // Divides the rays into batches of about `rays` rays, or of a size that suits the source. Returns the number of
  // batches.
  virtual std::size_t divide(std::size_t rays) = 0;
  // Makes batch `b` < divide(); called once for each. Different batches may be made and taken on several threads.
  virtual std::unique_ptr<RayBatch> make_batch(std::size_t b) = 0;
  // Takes a batch back, with the rays that ended, in their order.
  virtual void take_batch(RayBatch& batch) = 0;
};

// A source that makes its batches ray by ray, with the requested number of rays in each. Its make() and take() may be
// called from several threads.
class RayByRaySource : public RaySource {
 public:
  std::size_t divide(std::size_t rays) override;
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override;
  void take_batch(RayBatch& batch) override;

 protected:
  // Whether a ray for which make() returns nothing costs the DSP as much as one that returns.
  virtual bool pays_for_misses() const { return false; }

  std::size_t batch_rays_ = 1;
};

}  // namespace gicube::emu
