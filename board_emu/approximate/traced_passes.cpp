#include "approximate/traced_passes.h"

#include <map>
#include <memory>
#include <utility>

#include "datapath/composite.h"
#include "datapath/ray_step.h"
#include "functional/backproject.h"
#include "functional/functional_level.h"

namespace gicube::emu {

// Takes the rays to their ends, each in its own frame.
void TracedPasses::trace_parts(std::span<const wire::Ray> rays, std::span<const std::uint64_t> index,
                               std::span<std::int32_t> steps) {
  std::map<const Frame*, std::vector<std::size_t>> flying;
  for (std::size_t k = 0; k < rays.size(); ++k) flying[source_.frame_of(rays[k])].push_back(k);
  for (const auto& [frame, which] : flying) {
    std::vector<wire::Ray> some;
    std::vector<std::int32_t> of_some(which.size());
    for (const std::size_t k : which) some.push_back(rays[k]);
    counters_ += trace(some, *frame, tracer_, tracers(), of_some);
    const std::lock_guard lock(coming_back_mutex_);
    for (std::size_t i = 0; i < which.size(); ++i) {
      steps[which[i]] = of_some[i];
      if (of_some[i] > 0) {
        coming_back_[index[which[i]]] = some[i];
      } else {  // it is not sent
        source_.take(index[which[i]], some[i]);
      }
    }
  }
}

DspTask TracedPasses::taking(std::uint64_t i) {
  if (frame_.ends_at_borders) {
    const std::lock_guard lock(coming_back_mutex_);
    source_.take(which_.begin + i, coming_back_.extract(which_.begin + i).mapped());
  }
  return source_.taking(which_.begin + i);
}

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
  if (frame_.ends_at_borders) {
    trace_parts(rays, index, steps);
    for (std::size_t k = 0; k < rays.size(); ++k) ways[k]->begin_way(steps[k], contribution(rays[k].opacity));
    return;
  }
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
