// The values of rays that only gather, computed by the functional level as the rays are made: their times do not depend on them.
// The machine then moves rays on, and a ray's end is that of its steps.
//
// Who has to see a ray's words on its way, a checkpoint, gets them by taking its passes one by one from its beginning.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "datapath/frame.h"
#include "datapath/ray_step.h"
#include "functional/simd/simd_tracer.h"
#include "levels/ray_source.h"

namespace gicube::emu {

// What happened to rays but their number, samples and leaps, which have a place and a time.
inline RayCounters of_values(RayCounters counters) {
  counters.rays = counters.samples = counters.leaps = 0;
  return counters;
}

class ValuesAhead {
 public:
  // Of the rays `which` of `source`. `tracer`: prepared for the frame, or null. All must outlive this.
  ValuesAhead(RaySource& source, RayRange which, const Frame& frame, const SimdTracer* tracer, unsigned threads)
      : source_(source), which_(which), frame_(frame), tracer_(tracer), threads_(threads) {}
  // Whether the functional level can tell the steps of the frame's rays.
  static bool covers(const Frame& frame, const SimdTracer* tracer) {
    return (frame.plain() || (frame.gathers() && tracer != nullptr)) && !frame.in_bricks();
  }

  struct Ray {
    wire::Ray made, ended;
    std::int32_t steps = 0;
  };
  // Ray `i`, each once and in their order; as RaySource::make(). `ahead`: receives of_values() of rays on their ways. The machine counts
  // the rest when it comes to it.
  std::optional<Ray> make(std::uint64_t i, RayCounters& making, RayCounters& ahead);

  // The words of a ray after so many of its steps. What happens to it from there on is taken from `ahead`.
  RayState at(const Ray& ray, std::int32_t steps, RayCounters& ahead) const;
  // Computes no more values. What happens to rays that were not asked for yet is taken from `ahead`.
  void stop(RayCounters& ahead);
  bool has_stopped() const { return has_stopped_; }

 private:
  struct Made {
    std::optional<Ray> ray;
    RayCounters making;
  };
  void trace(RayCounters& ahead);
  void take_back(RayState ray, std::int32_t steps, RayCounters& ahead) const;
  void trace_steps(RayState& ray, std::int32_t steps, RayCounters& counters) const;

  RaySource& source_;
  RayRange which_;
  const Frame& frame_;
  const SimdTracer* tracer_;
  unsigned threads_;
  bool has_stopped_ = false;
  std::uint64_t next_ = 0;   // ray that was not asked for
  std::uint64_t begin_ = 0;  // the first of
  std::vector<Made> made_;
};

}  // namespace gicube::emu
