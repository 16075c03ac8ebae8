// A source's rays for the pass machine. The functional level computes their values as they are made; the machine then computes
// the time of each ray's passes, and asks here what the rays cost the DSP, as of a RaySource.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "approximate/pass_rays.h"
#include "functional/simd/simd_tracer.h"
#include "functional/trail.h"
#include "gicube/v1/board_config.pb.h"
#include "levels/ray_source.h"

namespace gicube::emu {

class TracedPasses {
 public:
  // The rays `which` of `source`. `tracer`: prepared for the frame, or null. `rule`: which samples write words though they deposit
  // nothing. Uses `threads` - 1 threads of the host; the machine has the other.
  TracedPasses(RaySource& source, RayRange which, const Frame& frame, const SimdTracer* tracer, unsigned threads,
               v1::SplatRule rule = v1::whole_units)
      : source_(source),
        which_(which),
        frame_(frame),
        tracer_(tracer),
        threads_(threads),
        record_{{}, rule == v1::visible_samples, rule == v1::all_samples} {}

  std::uint64_t count() const { return which_.end - which_.begin; }
  std::uint64_t run_end(std::uint64_t i) const {
    return std::min(source_.run_end(which_.begin + i), which_.end) - which_.begin;
  }
  std::uint64_t max_under_way() const { return source_.max_under_way(); }
  DspTask making(std::uint64_t i) const { return source_.making(which_.begin + i); }
  DspTask taking(std::uint64_t i) const { return source_.taking(which_.begin + i); }
  bool misses_are_free() const { return source_.misses_are_free(); }

  // Makes rays [begin, begin + out.size()) with their positions in the volume; called once for each ray, in order. A ray
  // without steps is made but not sent.
  void make(std::uint64_t begin, std::span<PassRay> out);

  // Once all are made.
  std::uint64_t made() const { return made_; }
  const RayCounters& rays() const { return counters_; }

 private:
  unsigned tracers() const { return threads_ > 1 ? threads_ - 1 : 1; }
  void follow(std::span<wire::Ray> rays, std::span<PassRay* const> out, std::vector<std::uint8_t>& ended);

  RaySource& source_;
  RayRange which_;
  const Frame& frame_;
  const SimdTracer* tracer_;
  unsigned threads_;
  TrailRecord record_;
  std::uint64_t made_ = 0;
  RayCounters counters_;
};

}  // namespace gicube::emu
