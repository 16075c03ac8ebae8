// What a command asks of a level: rays to make, and what to do with those that come back.
//
// A level takes the rays one by one in their order, as the DSP does, or in batches on several threads; never both in one run.
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

// Some of a source's rays, made, traced and taken back by one thread.
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

  std::span<wire::Ray> rays;         // those that go to the ASIC
  std::vector<wire::Ray> room;       // where they are kept, unless the source has a place for them
  std::vector<std::uint64_t> index;  // which of the source's rays they are; empty if it knows
  const Frame* frame = nullptr;      // in which they fly; null: the run's
  std::uint64_t returned = 0;        // rays that did not go there, and yet cost the DSP as much as one that comes back
  RayCounters counters;              // of what happened as they were made
};

// Rays [begin, end) of a source.
struct RayRange {
  std::uint64_t begin = 0;
  std::uint64_t end = 0;
};

// Viewing rays under way at most. Neighbours go through the same blocks at the same time: with more of them queues overflow more
// often and nothing is gained (docs/reference/hardware.md).
inline constexpr std::uint64_t kViewingRaysUnderWay = 8192;

class RaySource {
 public:
  virtual ~RaySource() = default;

  virtual std::uint64_t count() const = 0;

  // What making ray `i`, or the run that it begins, and taking it back cost the DSP.
  virtual DspTask making(std::uint64_t i) const = 0;
  virtual DspTask taking(std::uint64_t i) const = 0;
  // And before it is taken back: the search for a lamp that the ray sees where it has left.
  virtual DspTask looking(const wire::Ray&) const { return {}; }
  // DSP cycles of making and taking so many, where no order of them is known: each loop is begun once, and nothing waits.
  virtual std::uint64_t dsp_cycles(std::uint64_t made, std::uint64_t taken) const;
  // A ray that is not made has cost the DSP nothing: it passes over whole faces that the light does not reach.
  virtual bool misses_are_free() const { return false; }
  // The DSP makes rays i .. run_end(i) - 1 as one run, which goes down as a differential [P §3.6].
  virtual std::uint64_t run_end(std::uint64_t i) const { return i + 1; }
  // Rays that the DSP's memory holds between two runs of the ASIC: levels with time take so many, and then the next.
  virtual std::uint64_t max_at_once() const { return count(); }
  // Rays of it under way at most, if the overflow store has room for so many.
  virtual std::uint64_t max_under_way() const { return count(); }

  // Makes ray `i`, once for each. Nothing is returned for a ray that does not go to the ASIC: the source has done with it, and
  // has counted it in `counters`.
  virtual std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) = 0;
  // In which a ray that was made flies, as RayBatch::frame; of frames whose rays end at borders.
  virtual const Frame* frame_of(const wire::Ray& /*made*/) const { return nullptr; }
  // Takes ray `i` back after its flight, once for each ray that was made, unless it waits for the host. Its flags mean nothing then.
  virtual void take(std::uint64_t i, const wire::Ray& ray) = 0;

  // What the rays of the run that begins with ray `begin` have left in the source so far, or what a checkpoint has of it.
  virtual void state(Archive::Record& /*record*/, std::uint64_t /*begin*/) {}

  // Divides the rays into batches of about `rays` rays, or of a size that suits the source. Returns the number of batches.
  virtual std::size_t divide(std::size_t rays) = 0;
  // Makes batch `b` < divide(), each once. Both are called from several threads, for different batches.
  virtual std::unique_ptr<RayBatch> make_batch(std::size_t b) = 0;
  // Takes a batch back, with the rays that came to their ends, in their order.
  virtual void take_batch(RayBatch& batch) = 0;
};

// A source whose batches are made ray by ray, as many as asked for in each. Its make() and take() may be called from several
// threads.
class RayByRaySource : public RaySource {
 public:
  std::size_t divide(std::size_t rays) override;
  std::unique_ptr<RayBatch> make_batch(std::size_t b) override;
  void take_batch(RayBatch& batch) override;

 protected:
  // Whether a ray that make() keeps back costs the DSP as much as one that returns.
  virtual bool pays_for_misses() const { return false; }

 private:
  std::size_t batch_rays_ = 1;
};

}  // namespace gicube::emu
