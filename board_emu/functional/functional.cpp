#include "functional.h"

#include "datapath/interaction.h"
#include "datapath/ray_step.h"

namespace gicube::emu {

namespace {

// A ray that gathers and does nothing else.
Termination run_plain(RayState& ray_state, const Frame& frame, RayCounters& counters, std::int32_t& taken) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  std::size_t here = ~std::size_t{0};
  BlockView view;
  Point low{};
  Termination how = Termination::kNot;
  while ((how = end(ray_state, frame)) == Termination::kNot) {
    const std::size_t block = grid.block(ray_state.position);
    if (block != here) {
      here = block;
      view = frame.volume->view(block);
      low = grid.low(ray_state.position);
    }
    if (is_leapt_over(block, frame)) {
      taken += leap(ray_state, low, grid.size(), frame, counters);
      continue;
    }
    const Cell at = cell(ray_state.position, low);
    gather(ray_state, {at, view, block, edge}, frame, counters);
    ++taken;
  }
  return how;
}

// The DSP's routine scatters the ray; kTrapped if it is the host's to do.
Outcome scatter_trapped(RayState& ray_state, const Frame& frame, RayCounters& counters) {
  std::uint32_t cycles = 0;
  const Interaction interaction = resolve_trap(ray_state, frame, counters, cycles);
  counters.trap_cycles += cycles;
  return interaction.outcome;
}

// A ray that also deposits, or is scattered.
Termination run(RayState& ray_state, const Frame& frame, RayCounters& counters) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  Termination how = Termination::kNot;
  while ((how = end(ray_state, frame)) == Termination::kNot) {
    const std::size_t block = grid.block(ray_state.position);
    const Point low = grid.low(ray_state.position);
    if (is_leapt_over(block, frame)) {
      leap(ray_state, low, grid.size(), frame, counters);
      continue;
    }
    const Cell at = cell(ray_state.position, low);
    const BlockView view = frame.volume->view(block);
    const Interaction interaction = sample(ray_state, {at, view, block, edge}, frame, counters);
    if (interaction.deposits) counters.energy.deposited += frame.irradiance->add(interaction.deposit);
    Outcome outcome = interaction.outcome;
    if (outcome == Outcome::kTrapped) outcome = scatter_trapped(ray_state, frame, counters);
    if (outcome == Outcome::kEnded) return Termination::kAbsorbed;
    if (outcome == Outcome::kTrapped) return Termination::kWaits;
  }
  return how;
}

}  // namespace

bool integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps) {
  RayState ray_state = unpack(ray, frame);
  std::int32_t taken = 0;
  const Termination how =
      frame.plain() ? run_plain(ray_state, frame, counters, taken) : run(ray_state, frame, counters);
  if (steps != nullptr) *steps = taken;
  if (how == Termination::kWaits) return false;
  count_end(ray_state, how, frame, counters);
  pack(ray_state, frame, ray);
  return true;
}

}  // namespace gicube::emu
