#include "approximate/traced_passes.h"

#include <memory>
#include <utility>

#include "datapath/composite.h"
#include "datapath/ray_step.h"
#include "functional/backproject.h"
#include "functional/functional_level.h"

namespace gicube::emu {

// Of frames that are not plain.
void TracedPasses::follow(std::span<wire::Ray> rays, std::span<PassRay* const> out, std::vector<std::uint8_t>& ended) {
  std::vector<RayTrail> trails(rays.size());
  record_.trails = trails;
  ended = trace_recorded(rays, frame_, record_, tracer_, tracers(), counters_);
  for (std::size_t k = 0; k < rays.size(); ++k) {
    std::vector<TrailEvent>& events = trails[k].events;
    out[k]->begin_way(events.front().steps, events.front().contribution);
    if (events.size() == 1 && !events.front().deposits && !events.front().trapped && !frame_.lamps) continue;
    out[k]->route = std::make_unique<PassRoute>();
    out[k]->route->events = std::move(events);
    if (frame_.lamps && ended[k] != 0) out[k]->route->looking = source_.looking(rays[k]);
  }
}

void TracedPasses::make(std::uint64_t begin, std::span<PassRay> out) {
  std::vector<wire::Ray> rays;
  std::vector<PassRay*> ways;
  std::vector<std::uint64_t> index;
  for (std::size_t i = 0; i < out.size(); ++i) {
    PassRay& way = out[i] = {};
    const std::uint64_t which = which_.begin + begin + i;
    const auto ray = source_.make(which, counters_);
    if (!ray) continue;
    const RayState ray_state = unpack(*ray, frame_);
    way.follow(way_of(ray_state), frame_.jitter);
    if (frame_.sums != nullptr) way.amount = ray_state.amount();
    way.next_contribution = contribution(ray_state);
    rays.push_back(*ray);
    ways.push_back(&way);
    index.push_back(which);
  }
  made_ += rays.size();
  std::vector<std::uint8_t> ended(rays.size(), 1);
  std::vector<std::int32_t> steps(rays.size());
  const bool sums = frame_.sums != nullptr;
  if (sums || frame_.plain() || (tracer_ != nullptr && frame_.gathers())) {
    if (sums) {
      counters_ += backproject(rays, frame_, tracers(), steps);
    } else {
      counters_ += trace(rays, frame_, tracer_, tracers(), steps);
    }
    for (std::size_t k = 0; k < rays.size(); ++k) {
      ways[k]->begin_way(steps[k], sums ? ways[k]->next_contribution : contribution(rays[k].opacity));
    }
  } else {
    follow(rays, ways, ended);
  }
  for (std::size_t k = 0; k < rays.size(); ++k) {
    if (ended[k] != 0) source_.take(index[k], rays[k]);
  }
}

}  // namespace gicube::emu
