#include "firmware/ray_life.h"

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "datapath/scattering.h"

namespace gicube::emu {

namespace {

// Records the sample at the ray's position. `exponent`: of the step that it represents.
void record_sample(RayIteration& iteration, std::uint32_t exponent, const Frame& frame) {
  const Sample sample = sample_at(iteration.position, frame);
  iteration.tag = sample.tag;
  iteration.channels = sample.channels;
  iteration.entry = static_cast<std::uint32_t>(sample.index);
  iteration.colour = frame.shade ? shade(sample.entry, sample.gradient(), frame.reflectance_map)
                                 : Colour12{sample.entry.colour[0], sample.entry.colour[1], sample.entry.colour[2]};
  if (!visible(sample.index, frame)) return;
  if (gathers_wide(frame)) {
    iteration.alpha =
        static_cast<std::uint32_t>(wide_alpha(frame.wide_depths[sample.index], exponent) * wire::kOpacityOne);
  } else {
    iteration.alpha = (*frame.opacity_correction)(sample.entry.opacity, exponent);
  }
}

// Scatters a trapped ray by a routine of the board. Returns kWaits if the host must do it.
Termination scatter_by_routine(RayState& ray, const Frame& frame, RayCounters& counters) {
  if (frame.materials[ray.flags >> kTrapTagShift].routine == wire::kHostRoutine) return Termination::kWaits;
  const auto trap = trap_of(ray, frame);
  const ScatterAnswer answer = frame.routines->scatter(trap->routine, trap->event);
  const bool ends = answer_trap(ray, answer, frame, counters).outcome == Outcome::kEnded;
  return ends ? Termination::kAbsorbed : Termination::kActive;
}

// One iteration of a ray that has not ended.
Termination life_iteration(RayState& ray, RayIteration& iteration, const Frame& frame, RayCounters& counters) {
  const BlockGrid grid(*frame.volume);
  const Point low = grid.low(ray.position);
  iteration.position = ray.position;
  iteration.block = grid.block(ray.position);
  if (is_skipped(iteration.block, frame)) {
    iteration.skipped = skip_block(ray, low, grid.size(), frame, counters);
    return Termination::kActive;
  }
  const Cell at = cell(ray.position, low);
  const BlockView view = frame.volume->view(iteration.block);
  const SampleSite site{at, view, iteration.block, static_cast<std::size_t>(frame.volume->block_voxels()) + 1};
  RayState drawn = ray;  // with the step that the iteration will draw
  jitter_step(drawn, frame);
  record_sample(iteration, drawn.exponent, frame);
  if (frame.plain()) {
    gather(ray, site, frame, counters);
    return Termination::kActive;
  }
  const auto generation = ray.generation;
  const Outcome outcome = sample(ray, site, frame, counters).outcome;
  Termination how = outcome == Outcome::kEnded ? Termination::kAbsorbed : Termination::kActive;
  if (outcome == Outcome::kTrapped) how = scatter_by_routine(ray, frame, counters);
  iteration.scattered = outcome == Outcome::kTrapped || ray.generation != generation;
  return how;
}

}  // namespace

RayLife follow(const wire::Ray& ray, const Frame& frame) {
  RayLife life;
  life.ray = ray;
  RayCounters ignored;
  RayState state = unpack(ray, frame);
  Termination how = Termination::kActive;
  while (how == Termination::kActive && (how = end(state, frame)) == Termination::kActive) {
    RayIteration iteration;
    how = life_iteration(state, iteration, frame, ignored);
    iteration.gathered = state.colour;
    iteration.opacity = state.opacity;
    life.iterations.push_back(iteration);
  }
  constexpr const char* kEnds[] = {"", "left", "opaque", "absorbed", "host", ""};
  life.end = kEnds[static_cast<std::size_t>(how)];
  pack_ended(state, frame, life.ray);
  return life;
}

}  // namespace gicube::emu
