// A source's rays for the pass machine. The functional level computes their values as they are made; the machine then computes
// the time of each ray's passes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "approximate/pass_machine.h"
#include "functional/simd/simd_tracer.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class TracedPasses : public PassRaySource {
 public:
  // The rays `which` of `source`, of a plain frame. `tracer`: prepared for it, or null. Uses `threads` - 1 threads of the host;
  // the machine has the other.
  TracedPasses(RaySource& source, RayRange which, const Frame& frame, const SimdTracer* tracer, unsigned threads)
      : source_(source), which_(which), frame_(frame), tracer_(tracer), threads_(threads) {}

  std::uint64_t count() const override { return which_.end - which_.begin; }
  std::uint64_t run_end(std::uint64_t i) const override {
    return std::min(source_.run_end(which_.begin + i), which_.end) - which_.begin;
  }
  std::uint64_t max_under_way() const override { return source_.max_under_way(); }
  DspTask making(std::uint64_t i) const override { return source_.making(which_.begin + i); }
  DspTask taking(std::uint64_t i) const override { return source_.taking(which_.begin + i); }

  void make(std::uint64_t begin, std::span<PassRay> out) override;

  // Once all are made.
  std::uint64_t made() const { return made_; }
  const RayCounters& rays() const { return counters_; }

 private:
  RaySource& source_;
  RayRange which_;
  const Frame& frame_;
  const SimdTracer* tracer_;
  unsigned threads_;
  std::uint64_t made_ = 0;
  RayCounters counters_;
};

}  // namespace gicube::emu
