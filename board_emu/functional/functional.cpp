#include "functional.h"

#include <algorithm>
#include <utility>

#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "datapath/waiting_ray.h"

namespace gicube::emu {

namespace {

// A ray that gathers and does nothing else. kWaits: for a block.
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
      if (is_absent(block, frame)) return Termination::kWaits;
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

// A ray that also deposits, or is scattered. kWaits: it is trapped.
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
    if (interaction.outcome == Outcome::kEnded) return Termination::kAbsorbed;
    if (interaction.outcome == Outcome::kTrapped) return Termination::kWaits;
  }
  return how;
}

// Rays that fly until they end, are trapped or wait for a block.
class Flights {
 public:
  Flights(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters)
      : rays_(rays), frame_(frame), counters_(counters), ended_(rays.size()) {}

  void begin(std::size_t ray) { fly({ray, unpack_or_continue(rays_[ray], frame_), {}}); }
  bool are_waiting() const { return !waiting_.empty(); }

  // The routines scatter those that wait, and they fly on.
  void scatter() {
    std::vector<Flight> flights;
    flights.swap(waiting_);
    std::stable_sort(flights.begin(), flights.end(),
                     [](const Flight& a, const Flight& b) { return a.trap.routine < b.trap.routine; });
    std::vector<ScatterEvent> events;
    for (const Flight& flight : flights) events.push_back(flight.trap.event);
    std::vector<ScatterAnswer> answers(events.size());
    for (std::size_t first = 0, last = 0; first < flights.size(); first = last) {
      const std::uint8_t routine = flights[first].trap.routine;
      while (last < flights.size() && flights[last].trap.routine == routine) ++last;
      frame_.routines->scatter_all(routine, std::span(events).subspan(first, last - first),
                                   std::span(answers).subspan(first, last - first));
    }
    for (std::size_t i = 0; i < flights.size(); ++i) {
      const Interaction interaction = answer_trap(flights[i].ray_state, answers[i], frame_, counters_);
      if (interaction.outcome == Outcome::kEnded) {
        end_with(flights[i], Termination::kAbsorbed);
      } else {
        fly(flights[i]);
      }
    }
  }

  std::vector<bool> ended() && { return std::move(ended_); }

 private:
  struct Flight {
    std::size_t ray;
    RayState ray_state;
    Trap trap;
  };

  void fly(Flight flight) {
    std::int32_t taken = 0;
    const Termination how = frame_.plain() ? run_plain(flight.ray_state, frame_, counters_, taken)
                                           : run(flight.ray_state, frame_, counters_);
    if (how != Termination::kWaits) return end_with(flight, how);
    if (frame_.in_bricks()) {
      return wait_for(BlockGrid(*frame_.volume).block(flight.ray_state.position), flight.ray_state, frame_);
    }
    if (const auto trap = trap_of(flight.ray_state, frame_)) {
      flight.trap = *trap;
      waiting_.push_back(flight);
    }
  }

  void end_with(const Flight& flight, Termination how) {
    count_end(flight.ray_state, how, frame_, counters_);
    pack_ended(flight.ray_state, frame_, rays_[flight.ray]);
    ended_[flight.ray] = true;
  }

  std::span<wire::Ray> rays_;
  const Frame& frame_;
  RayCounters& counters_;
  std::vector<bool> ended_;
  std::vector<Flight> waiting_;
};

}  // namespace

void integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps) {
  RayState ray_state = unpack(ray, frame);
  std::int32_t taken = 0;
  const Termination how =
      frame.plain() ? run_plain(ray_state, frame, counters, taken) : run(ray_state, frame, counters);
  if (steps != nullptr) *steps = taken;
  count_end(ray_state, how, frame, counters);
  pack(ray_state, frame, ray);
}

std::vector<bool> integrate_all(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters) {
  Flights flights(rays, frame, counters);
  for (std::size_t i = 0; i < rays.size(); ++i) flights.begin(i);
  while (flights.are_waiting()) flights.scatter();
  return std::move(flights).ended();
}

}  // namespace gicube::emu
