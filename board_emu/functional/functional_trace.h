// Trace of rays that only gather: the functional level computes their values when they are made, because their times do
// not depend on their values. The machine then only advances them, and a ray ends with its last step.
//
// A checkpoint needs the words of rays under way. They are computed by repeating the ray's steps from its start.
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

// Returns the counters except the numbers of rays, samples and skips, which the machine counts when they occur.
inline RayCounters of_values(RayCounters counters) {
  counters.rays = counters.samples = counters.leaps = 0;
  return counters;
}

class FunctionalTrace {
 public:
  // Traces the rays `which` of `source`. `tracer`: prepared for the frame, or null. All arguments must outlive this.
  FunctionalTrace(RaySource& source, RayRange which, const Frame& frame, const SimdTracer* tracer, unsigned threads)
      : source_(source), which_(which), frame_(frame), tracer_(tracer), threads_(threads) {}
  // Whether the functional level can compute the numbers of steps of the frame's rays.
  static bool covers(const Frame& frame, const SimdTracer* tracer) {
    return (frame.plain() || (frame.gathers() && tracer != nullptr)) && !frame.in_bricks();
  }

  struct Ray {
    wire::Ray made, ended;
    std::int32_t steps = 0;
  };
  // Returns ray `i` with its trace, like RaySource::make(). Rays must be requested once each and in order. `ahead`:
  // receives of_values() of the traced rays, which need not be requested yet. The machine counts the rest when it
  // occurs.
  std::optional<Ray> make(std::uint64_t i, RayCounters& making, RayCounters& ahead);

  // Returns the words of a ray after `steps` steps. Subtracts the values of its further steps from `ahead`.
  RayState at(const Ray& ray, std::int32_t steps, RayCounters& ahead) const;
  // Stops computing values. Subtracts the values of rays that were not requested yet from `ahead`.
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
  std::uint64_t next_ = 0;   // next ray to be requested
  std::uint64_t begin_ = 0;  // first ray of made_
  std::vector<Made> made_;
};

}  // namespace gicube::emu
