#include "functional/functional_trace.h"

#include <algorithm>

#include "datapath/interaction.h"
#include "functional/functional_level.h"
#include "words/block_grid.h"

namespace gicube::emu {

namespace {

constexpr std::uint64_t kAtOnce = 2048;  // chosen: some groups of the tracer per thread

}  // namespace

void FunctionalTrace::trace(RayCounters& ahead) {
  std::vector<wire::Ray> rays;
  for (const Made& made : made_) {
    if (made.ray) rays.push_back(made.ray->made);
  }
  std::vector<std::int32_t> steps(rays.size());
  ahead += of_values(emu::trace(rays, frame_, tracer_, threads_, steps));
  std::size_t next = 0;
  for (Made& made : made_) {
    if (!made.ray) continue;
    made.ray->ended = rays[next];
    made.ray->steps = steps[next++];
  }
}

std::optional<FunctionalTrace::Ray> FunctionalTrace::make(std::uint64_t i, RayCounters& making, RayCounters& ahead) {
  next_ = i + 1;
  if (i >= begin_ + made_.size() && !has_stopped_) {
    begin_ = i;
    made_.assign(std::min(kAtOnce, which_.end - i), {});
    for (Made& made : made_) {
      if (const auto ray = source_.make(i++, made.making)) made.ray = {*ray, {}, 0};
    }
    i = begin_;
    trace(ahead);
  }
  if (i < begin_ + made_.size()) {
    making += made_[i - begin_].making;
    return made_[i - begin_].ray;
  }
  const auto ray = source_.make(i, making);
  return ray ? std::optional<Ray>({*ray, {}, 0}) : std::nullopt;
}

void FunctionalTrace::trace_steps(RayState& ray, std::int32_t steps, RayCounters& counters) const {
  const BlockGrid grid(*frame_.volume);
  const std::size_t edge = static_cast<std::size_t>(frame_.volume->block_voxels()) + 1;
  while (steps > 0) {
    const Point low = grid.low(ray.position);
    const std::size_t block = grid.block(ray.position);
    if (is_skipped(block, frame_)) {
      steps -= skip_block(ray, low, grid.size(), frame_, counters);
      continue;
    }
    const Cell at = cell(ray.position, low);
    const BlockView view = frame_.volume->view(block);
    const SampleSite site{at, view, block, edge};
    frame_.plain() ? gather(ray, site, frame_, counters) : void(sample(ray, site, frame_, counters));
    --steps;
  }
}

// Subtracts the counters of the ray's last `steps` steps from `ahead`.
void FunctionalTrace::take_back(RayState ray, std::int32_t steps, RayCounters& ahead) const {
  RayCounters rest;
  trace_steps(ray, steps, rest);
  count_end(ray, end(ray, frame_), frame_, rest);
  ahead = ahead - of_values(rest);
}

RayState FunctionalTrace::at(const Ray& ray, std::int32_t steps, RayCounters& ahead) const {
  RayCounters past;
  RayState state = unpack(ray.made, frame_);
  trace_steps(state, steps, past);
  if (steps < ray.steps) take_back(state, ray.steps - steps, ahead);
  return state;
}

void FunctionalTrace::stop(RayCounters& ahead) {
  has_stopped_ = true;
  for (std::uint64_t i = next_; i < begin_ + made_.size(); ++i) {
    if (const auto& ray = made_[i - begin_].ray) take_back(unpack(ray->made, frame_), ray->steps, ahead);
  }
}

}  // namespace gicube::emu
