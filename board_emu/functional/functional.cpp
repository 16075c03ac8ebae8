#include "functional.h"

#include "datapath/interaction.h"
#include "datapath/ray_step.h"

namespace gicube::emu {

namespace {

// A ray that gathers and does nothing else.
Termination gather(RayState& ray_state, WideWords* wide, const Frame& frame, RayCounters& counters,
                   std::int32_t& taken) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  std::size_t block = ~std::size_t{0};
  Point low{};
  BlockView view;
  Termination how = Termination::kNot;
  while ((how = end(ray_state, frame)) == Termination::kNot) {
    jitter_step(ray_state, frame);
    if (const std::size_t next = grid.block(ray_state.position); next != block) {
      block = next;
      low = grid.low(ray_state.position);
      view = frame.volume->view(block);
    }
    if (frame.leap && frame.empty[block] != 0) {
      ++counters.leaps;
      const std::int32_t steps = leap_steps(ray_state, low, grid.size(), frame);
      advance(ray_state, steps);
      count_steps(ray_state, steps, frame);
      taken += steps;
      continue;
    }
    ++counters.samples;
    if (take_sample(ray_state, wide, cell(ray_state.position, low), view, edge, frame)) ++counters.visible_samples;
    advance(ray_state, 1);
    count_steps(ray_state, 1, frame);
    ++taken;
  }
  return how;
}

// The DSP's routine scatters the ray; kTrapped if it is the host's to do.
Outcome scatter_trapped(RayState& ray_state, WideWords* wide, const Frame& frame, RayCounters& counters) {
  std::uint32_t cycles = 0;
  const Interaction met = resolve_trap(ray_state, wide, frame, counters, cycles);
  counters.trap_cycles += cycles;
  return met.outcome;
}

// A ray that also deposits, or is scattered.
Termination travel(RayState& ray_state, WideWords* wide, const Frame& frame, RayCounters& counters) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  Termination how = Termination::kNot;
  while ((how = end(ray_state, frame)) == Termination::kNot) {
    jitter_step(ray_state, frame);
    const std::size_t block = grid.block(ray_state.position);
    const Point low = grid.low(ray_state.position);
    if (frame.leap && frame.empty[block] != 0) {
      ++counters.leaps;
      leave_surface(ray_state);
      const std::int32_t steps = leap_steps(ray_state, low, grid.size(), frame);
      advance(ray_state, steps);
      count_steps(ray_state, steps, frame);
      continue;
    }
    ++counters.samples;
    const Interaction met = interact(ray_state, wide, cell(ray_state.position, low), frame.volume->view(block), block,
                                     edge, frame, counters);
    if (met.visible) ++counters.visible_samples;
    if (met.deposits) counters.energy.deposited += frame.irradiance->add(met.deposit);
    Outcome outcome = met.outcome;
    if (outcome == Outcome::kTrapped) outcome = scatter_trapped(ray_state, wide, frame, counters);
    if (outcome == Outcome::kEnded) return Termination::kAbsorbed;
    if (outcome == Outcome::kTrapped) return Termination::kWaits;
    count_steps(ray_state, 1, frame);
  }
  return how;
}

}  // namespace

bool integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps) {
  RayState ray_state = unpack(ray, frame);
  std::int32_t taken = 0;
  WideWords words = wide_words(ray_state);
  WideWords* const wide = gathers_wide(frame) ? &words : nullptr;
  const Termination how =
      frame.plain ? gather(ray_state, wide, frame, counters, taken) : travel(ray_state, wide, frame, counters);
  if (steps != nullptr) *steps = taken;
  if (how == Termination::kWaits) return false;
  count_end(ray_state, how, frame, counters);
  pack(ray_state, frame, ray);
  return true;
}

}  // namespace gicube::emu
