#include "functional.h"

#include <algorithm>
#include <utility>

#include "datapath/bricks.h"
#include "datapath/interaction.h"
#include "datapath/ray_step.h"
#include "functional/flight.h"
#include "functional/simd/simd_tracer.h"

namespace gicube::emu {

namespace {

// Traces a ray that only gathers.
Termination run_plain(RayState& ray_state, const Frame& frame, RayCounters& counters, std::int32_t& taken) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  std::size_t here = ~std::size_t{0};
  BlockView view;
  Point low{};
  Termination how = Termination::kActive;
  while ((how = end(ray_state, frame)) == Termination::kActive) {
    const std::size_t block = grid.block(ray_state.position);
    if (block != here) {
      if (is_non_resident(block, frame)) return Termination::kNonResident;
      here = block;
      view = frame.volume->view(block);
      low = grid.low(ray_state.position);
    }
    if (is_skipped(block, frame)) {
      taken += skip_block(ray_state, low, grid.size(), frame, counters);
      continue;
    }
    const Cell at = cell(ray_state.position, low);
    gather(ray_state, {at, view, block, edge}, frame, counters);
    ++taken;
  }
  return how;
}

// One iteration of a ray that also deposits or is scattered.
Termination pass(RayState& ray_state, const BlockGrid& grid, const Frame& frame, RayCounters& counters) {
  const std::size_t block = grid.block(ray_state.position);
  if (is_non_resident(block, frame)) return Termination::kNonResident;
  const Point low = grid.low(ray_state.position);
  if (is_skipped(block, frame)) {
    skip_block(ray_state, low, grid.size(), frame, counters);
    return Termination::kActive;
  }
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  const Cell at = cell(ray_state.position, low);
  const BlockView view = frame.volume->view(block);
  const Interaction interaction = sample(ray_state, {at, view, block, edge}, frame, counters);
  if (interaction.deposits && frame.light_words == 1) {
    give_host(interaction.deposit, frame);
    counters.energy.deposited += frame.irradiance->add(on_card(interaction.deposit, frame));
  } else if (interaction.deposits) {
    for (std::size_t word = 0; word < frame.light_words; ++word) {
      counters.energy_of(word).deposited += frame.irradiance[word].add(deposit_in(word, interaction, ray_state, frame));
    }
  }
  if (interaction.outcome == Outcome::kEnded) return Termination::kAbsorbed;
  return interaction.outcome == Outcome::kTrapped ? Termination::kWaits : Termination::kActive;
}

Termination run(RayState& ray_state, const Frame& frame, RayCounters& counters) {
  const BlockGrid grid(*frame.volume);
  Termination how = Termination::kActive;
  while (how == Termination::kActive && (how = end(ray_state, frame)) == Termination::kActive) {
    how = pass(ray_state, grid, frame, counters);
  }
  return how;
}

// Traces rays until they end, are trapped or wait for a block.
class Flights {
 public:
  Flights(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters, const SimdTracer* tracer,
          std::span<const std::uint64_t> indices)
      : rays_(rays),
        frame_(frame),
        counters_(counters),
        tracer_(tracer),
        indices_(indices),
        ended_(rays.size()) {}

  std::vector<bool> run() && {
    std::vector<Flight> flights, traps;
    flights.reserve(rays_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const Flight flight(i, begin_or_go_on(rays_[i], index_of(i), frame_));
      (waited_trapped(i) ? traps : flights).push_back(flight);
    }
    for (Flight& flight : traps) flight.how = Termination::kWaits;
    while (!flights.empty() || !traps.empty()) {
      fly_all(flights);
      flights.insert(flights.end(), traps.begin(), traps.end());
      traps.clear();
      flights = scattered(trapped(flights));
    }
    return std::move(ended_);
  }

 private:
  void fly_all(std::span<Flight> flights) {
    if (tracer_ != nullptr) return tracer_->fly(flights, frame_, counters_);
    for (Flight& flight : flights) fly(flight, frame_, counters_);
  }

  std::uint64_t index_of(std::size_t ray) const { return indices_.empty() ? ray : indices_[ray]; }
  bool waited_trapped(std::size_t ray) const {
    const WaitingRay* const waited = frame_.in_bricks() ? frame_.waiting->find(index_of(ray)) : nullptr;
    return waited != nullptr && waited->trapped;
  }
  std::size_t block_of(const Flight& flight) const {
    return BlockGrid(*frame_.volume).block(flight.ray_state.position);
  }
  void wait(const Flight& flight, bool is_trapped) {
    const auto block = static_cast<std::uint32_t>(block_of(flight));
    frame_.waiting->add({.ray_state = flight.ray_state, .block = block, .trapped = is_trapped}, index_of(flight.ray));
  }

  // Returns the flights that a routine answers; completes the others.
  std::vector<Flight> trapped(std::span<Flight> flights) {
    std::vector<Flight> out;
    for (Flight& flight : flights) {
      if (flight.how == Termination::kNonResident) {
        wait(flight, false);
      } else if (flight.how != Termination::kWaits) {
        end_with(flight, flight.how);
      } else if (is_non_resident_for_routine(block_of(flight), frame_)) {
        wait(flight, true);
      } else if (const auto trap = trap_of(flight.ray_state, frame_)) {
        flight.trap = *trap;
        out.push_back(flight);
      }
    }
    return out;
  }

  // Scatters the flights by their routines. Returns those that continue.
  std::vector<Flight> scattered(std::vector<Flight> flights) {
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
    std::vector<Flight> out;
    for (std::size_t i = 0; i < flights.size(); ++i) {
      const Interaction interaction = answer_trap(flights[i].ray_state, answers[i], frame_, counters_);
      if (interaction.outcome == Outcome::kEnded) {
        end_with(flights[i], Termination::kAbsorbed);
      } else {
        out.push_back(flights[i]);
      }
    }
    return out;
  }

  void end_with(const Flight& flight, Termination how) {
    count_end(flight.ray_state, how, frame_, counters_);
    pack_ended(flight.ray_state, frame_, rays_[flight.ray]);
    ended_[flight.ray] = true;
  }

  std::span<wire::Ray> rays_;
  const Frame& frame_;
  RayCounters& counters_;
  const SimdTracer* tracer_;                // null: rays are traced one by one
  std::span<const std::uint64_t> indices_;  // indices of the rays in their source; empty: as in rays_
  std::vector<bool> ended_;
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

Termination take_pass(RayState& ray_state, const Frame& frame, RayCounters& counters) {
  return pass(ray_state, BlockGrid(*frame.volume), frame, counters);
}

void fly(Flight& flight, const Frame& frame, RayCounters& counters) {
  std::int32_t taken = 0;
  flight.how = frame.plain() ? run_plain(flight.ray_state, frame, counters, taken)
                             : run(flight.ray_state, frame, counters);
}

std::vector<bool> integrate_all(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                                const SimdTracer* tracer, std::span<const std::uint64_t> indices) {
  return Flights(rays, frame, counters, tracer, indices).run();
}

}  // namespace gicube::emu
