#include "datapath/ray_life.h"

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "datapath/scattering.h"

namespace gicube::emu {

namespace {

// What the sample at the ray's place is; `exponent`: of the step that it stands for.
void look(RayPass& pass, const SampleSite& site, std::uint32_t exponent, const Frame& frame) {
  Sample sample;
  if (site.view.voxels != nullptr) {
    sample = sample_at(pass.position, frame);
  } else {  // no gradients are decoded, since nothing is shaded
    const std::size_t row = site.edge, slice = row * row;
    const std::size_t first = site.cell.voxel[0] + row * site.cell.voxel[1] + slice * site.cell.voxel[2];
    constexpr std::uint32_t kHalf = wire::kVoxel / 2;
    if (site.view.tags != nullptr) {
      sample.tag = site.view.tags[first + (site.cell.fraction[0] >= kHalf) + row * (site.cell.fraction[1] >= kHalf) +
                                  slice * (site.cell.fraction[2] >= kHalf)];
    }
    sample.channels = resample_view(site.view, first, site.cell, row, slice);
    sample.index = segmentation_index(sample.channels[0], sample.tag);
    sample.entry = &frame.segmentation[sample.index];
  }
  pass.tag = sample.tag;
  pass.channels = sample.channels;
  pass.entry = static_cast<std::uint32_t>(sample.index);
  pass.colour = frame.shade ? shade(*sample.entry, sample.gradient(), frame.reflectance_map)
                            : Colour12{sample.entry->colour[0], sample.entry->colour[1], sample.entry->colour[2]};
  if (!visible(sample.index, frame)) return;
  if (gathers_wide(frame)) {
    pass.alpha = static_cast<std::uint32_t>(wide_alpha(frame.wide_depths[sample.index], exponent) * wire::kOpacityOne);
  } else {
    pass.alpha = (*frame.opacity_correction)(sample.entry->opacity, exponent);
  }
}

// Scatters a trapped ray by a routine of the board. What becomes of it: kWaits if the host must.
Termination scatter(RayState& ray, const Frame& frame, RayCounters& counters) {
  if (frame.materials[ray.flags >> kTrapTagShift].routine == wire::kHostRoutine) return Termination::kWaits;
  const auto trap = trap_of(ray, frame);
  const ScatterAnswer answer = frame.routines->scatter(trap->routine, trap->event);
  const bool ends = answer_trap(ray, answer, frame, counters).outcome == Outcome::kEnded;
  return ends ? Termination::kAbsorbed : Termination::kNot;
}

// One pass of a ray that has not ended.
Termination pass_of(RayState& ray, RayPass& pass, const Frame& frame, RayCounters& counters) {
  const BlockGrid grid(*frame.volume);
  const Point low = grid.low(ray.position);
  pass.position = ray.position;
  pass.block = grid.block(ray.position);
  if (is_leapt_over(pass.block, frame)) {
    pass.leap = leap(ray, low, grid.size(), frame, counters);
    return Termination::kNot;
  }
  const Cell at = cell(ray.position, low);
  const BlockView view = frame.volume->view(pass.block);
  const SampleSite site{at, view, pass.block, static_cast<std::size_t>(frame.volume->block_voxels()) + 1};
  RayState drawn = ray;  // with the step that the pass will draw
  jitter_step(drawn, frame);
  look(pass, site, drawn.exponent, frame);
  if (frame.plain()) {
    gather(ray, site, frame, counters);
    return Termination::kNot;
  }
  const auto generation = ray.generation;
  const Outcome outcome = sample(ray, site, frame, counters).outcome;
  Termination how = outcome == Outcome::kEnded ? Termination::kAbsorbed : Termination::kNot;
  if (outcome == Outcome::kTrapped) how = scatter(ray, frame, counters);
  pass.scattered = outcome == Outcome::kTrapped || ray.generation != generation;
  return how;
}

}  // namespace

RayLife follow(const wire::Ray& ray, const Frame& frame) {
  RayLife life;
  life.ray = ray;
  RayCounters ignored;
  RayState state = unpack(ray, frame);
  Termination how = Termination::kNot;
  while (how == Termination::kNot && (how = end(state, frame)) == Termination::kNot) {
    RayPass pass;
    how = pass_of(state, pass, frame, ignored);
    pass.gathered = state.colour;
    pass.opacity = state.opacity;
    life.passes.push_back(pass);
  }
  constexpr const char* kEnds[] = {"", "left", "opaque", "absorbed", "host"};
  life.end = kEnds[static_cast<std::size_t>(how)];
  pack_ended(state, frame, life.ray);
  return life;
}

}  // namespace gicube::emu
