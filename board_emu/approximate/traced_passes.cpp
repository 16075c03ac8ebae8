#include "approximate/traced_passes.h"

#include <algorithm>
#include <vector>

#include "datapath/ray_step.h"
#include "functional/functional_level.h"

namespace gicube::emu {

void TracedPasses::make(std::uint64_t begin, std::span<PassRay> out) {
  std::vector<wire::Ray> rays;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < out.size(); ++i) {
    PassRay& way = out[i] = {};
    const auto ray = source_.make(which_.begin + begin + i, counters_);
    if (!ray) continue;
    const RayState start = unpack(*ray, frame_);
    way.position = start.position;
    way.step = frame_.jitter ? drawn_from(start.direction, start.u, start.v) : start.step;
    way.rest = start.rest;
    way.step_rest = start.step_rest;
    rays.push_back(*ray);
    places.push_back(i);
  }
  made_ += rays.size();
  std::vector<std::int32_t> steps(rays.size());
  counters_ += trace(rays, frame_, tracer_, std::max(1u, threads_ - 1), steps);
  for (std::size_t k = 0; k < rays.size(); ++k) {
    out[places[k]].left = steps[k];
    source_.take(which_.begin + begin + places[k], rays[k]);
  }
}

}  // namespace gicube::emu
