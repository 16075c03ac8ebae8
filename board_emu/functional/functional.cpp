#include "functional.h"

#include <cmath>

#include "datapath/ray_step.h"
#include "datapath/interaction.h"

namespace gicube::emu {

std::uint32_t physical_length(const std::array<std::int16_t, 3>& direction,
                              const std::array<std::uint32_t, 3>& spacing) {
  if (spacing[0] == spacing[1] && spacing[1] == spacing[2]) return spacing[0];
  double voxels = 0, physical = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d = direction[axis], scaled = d * spacing[axis];
    voxels += d * d;
    physical += scaled * scaled;
  }
  return static_cast<std::uint32_t>(std::lround(std::sqrt(physical / voxels)));
}

namespace {

// A ray that gathers and does nothing else.
End gather(Traveller& traveller, WideWords* wide, const Frame& frame, RayCounters& counters, std::int32_t& taken) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  std::size_t block = ~std::size_t{0};
  Point low{};
  BlockView view;
  End how = End::kNot;
  while ((how = end(traveller, frame)) == End::kNot) {
    jitter_step(traveller, frame);
    if (const std::size_t next = grid.block(traveller.position); next != block) {
      block = next;
      low = grid.low(traveller.position);
      view = frame.volume->view(block);
    }
    if (frame.leap && frame.empty[block] != 0) {
      ++counters.leaps;
      const std::int32_t steps = leap_steps(traveller, low, grid.size(), frame);
      advance(traveller, steps);
      count_steps(traveller, steps, frame);
      taken += steps;
      continue;
    }
    ++counters.samples;
    if (take_sample(traveller, wide, cell(traveller.position, low), view, edge, frame)) ++counters.visible_samples;
    advance(traveller, 1);
    count_steps(traveller, 1, frame);
    ++taken;
  }
  return how;
}

// The DSP's routine scatters the ray; kTrapped if it is the host's to do.
Fate scatter_trapped(Traveller& traveller, WideWords* wide, const Frame& frame, RayCounters& counters) {
  std::uint32_t cycles = 0;
  const Met met = resolve_trap(traveller, wide, frame, counters, cycles);
  counters.trap_cycles += cycles;
  return met.fate;
}

// A ray that also deposits, or is scattered.
End travel(Traveller& traveller, WideWords* wide, const Frame& frame, RayCounters& counters) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  End how = End::kNot;
  while ((how = end(traveller, frame)) == End::kNot) {
    jitter_step(traveller, frame);
    const std::size_t block = grid.block(traveller.position);
    const Point low = grid.low(traveller.position);
    if (frame.leap && frame.empty[block] != 0) {
      ++counters.leaps;
      leave_surface(traveller);
      const std::int32_t steps = leap_steps(traveller, low, grid.size(), frame);
      advance(traveller, steps);
      count_steps(traveller, steps, frame);
      continue;
    }
    ++counters.samples;
    const Met met =
        meet(traveller, wide, cell(traveller.position, low), frame.volume->view(block), block, edge, frame, counters);
    if (met.visible) ++counters.visible_samples;
    if (met.deposits) counters.energy.deposited += frame.irradiance->add(met.deposit);
    Fate fate = met.fate;
    if (fate == Fate::kTrapped) fate = scatter_trapped(traveller, wide, frame, counters);
    if (fate == Fate::kEnded) return End::kSpent;
    if (fate == Fate::kTrapped) return End::kWaits;
    count_steps(traveller, 1, frame);
  }
  return how;
}

}  // namespace

bool integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps) {
  Traveller traveller = set_out(ray, frame);
  std::int32_t taken = 0;
  WideWords words = wide_words(traveller);
  WideWords* const wide = gathers_wide(frame) ? &words : nullptr;
  const End how =
      frame.plain ? gather(traveller, wide, frame, counters, taken) : travel(traveller, wide, frame, counters);
  if (steps != nullptr) *steps = taken;
  if (how == End::kWaits) return false;
  count_end(traveller, how, frame, counters);
  finish(traveller, frame, ray);
  return true;
}

}  // namespace gicube::emu
