// The functional level: values without time. Rays cost cycles of the DSP, but none of the ASIC.
//
// Rays are divided among host threads; their values do not depend on that.
#pragma once

#include <cstdint>
#include <span>

#include "datapath/frame.h"
#include "datapath/opacity_correction.h"
#include "functional/simd/simd_tracer.h"
#include "levels/level.h"

namespace gicube::emu {

class FunctionalLevel : public Level {
 public:
  // Runs on `threads` threads. `vectors`: traces rays in groups if the host has vectors.
  explicit FunctionalLevel(unsigned threads, bool vectors = true) : threads_(threads), vectors_(vectors) {}

  // Progress is in batches of rays.
  RunResult run(RaySource& rays, const Frame& frame, Progress& progress) override;

  void volume_changed() override { tracer_.clear(); }
  void deposits_cleared() override {}
  void reset() override { tracer_.clear(); }
  RayCounters rays() const override { return rays_; }
  void count(std::vector<wire::Counter>&) const override {}
  void state(Archive& archive, const std::array<int, 3>&) override { archive("rays", rays_); }

 private:
  unsigned threads_;
  bool vectors_;
  OpacityCorrection correction_;
  SimdTracer tracer_{correction_};
  RayCounters rays_;
};

// Traces rays that only gather to their ends, in place, on `threads` threads. `tracer`: prepared for this frame, or
// null. `steps`: receives each ray's number of steps.
RayCounters trace(std::span<wire::Ray> rays, const Frame& frame, const SimdTracer* tracer, unsigned threads,
                  std::span<std::int32_t> steps);

}  // namespace gicube::emu
