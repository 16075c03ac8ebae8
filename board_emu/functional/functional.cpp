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

// Where a sample was taken, and how many scatterings the ray then had left.
struct SampledAt {
  Point place;
  std::uint16_t lifetime;
};

// Adds what a sample brought about to the trail, if it is an event.
void note(const Interaction& interaction, const SampledAt& sampled, const RayState& ray, const TrailRecord& record,
          RayTrail& trail) {
  const bool writes =
      ray.is(wire::kLightingRay) && (record.all_samples || (record.visible_samples && interaction.visible));
  const bool turns = ray.lifetime != sampled.lifetime, trapped = interaction.outcome == Outcome::kTrapped;
  if (!interaction.deposits && !writes && !turns && !trapped) return;
  TrailEvent& event = trail.add();
  event.deposits = interaction.deposits || writes;
  event.trapped = trapped;
  event.turns = turns;
  if (turns) event.way = way_of(ray);
  if (event.deposits) event.deposit = interaction.deposits ? interaction.deposit : nothing_at(sampled.place);
  if (event.deposits && record.writes_all_voxels()) event.deposit.shares.fill(1);
}

// A ray that also deposits, or is scattered. kWaits: it is trapped. With kRecords its `trail` goes on.
template <bool kRecords>
Termination run(RayState& ray_state, const Frame& frame, RayCounters& counters, const TrailRecord* record = nullptr,
                RayTrail* trail = nullptr) {
  const BlockGrid grid(*frame.volume);
  const auto edge = static_cast<std::size_t>(frame.volume->block_voxels()) + 1;
  Termination how = Termination::kNot;
  while ((how = end(ray_state, frame)) == Termination::kNot) {
    const std::size_t block = grid.block(ray_state.position);
    const Point low = grid.low(ray_state.position);
    if (is_leapt_over(block, frame)) {
      const std::int32_t steps = leap(ray_state, low, grid.size(), frame, counters);
      if constexpr (kRecords) trail->since += steps;
      continue;
    }
    const Cell at = cell(ray_state.position, low);
    const BlockView view = frame.volume->view(block);
    [[maybe_unused]] const SampledAt sampled{ray_state.position, ray_state.lifetime};
    const Interaction interaction = sample(ray_state, {at, view, block, edge}, frame, counters);
    if constexpr (kRecords) {
      ++trail->since;
      note(interaction, sampled, ray_state, *record, *trail);
    }
    if (interaction.deposits) counters.energy.deposited += frame.irradiance->add(interaction.deposit);
    if (interaction.outcome == Outcome::kEnded) return Termination::kAbsorbed;
    if (interaction.outcome == Outcome::kTrapped) return Termination::kWaits;
  }
  return how;
}

// Rays that fly until they end, are trapped or wait for a block.
class Flights {
 public:
  Flights(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters, const TrailRecord* record)
      : rays_(rays), frame_(frame), counters_(counters), record_(record), ended_(rays.size()) {}

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
      if (record_ != nullptr) {
        TrailEvent& event = record_->trails[flights[i].ray].events.back();
        event.routine_cycles = answers[i].cycles;
        event.turns = true;
        event.way = way_of(flights[i].ray_state);
      }
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
    const Termination how = way(flight);
    if (how != Termination::kWaits) return end_with(flight, how);
    if (frame_.in_bricks()) {
      return wait_for(BlockGrid(*frame_.volume).block(flight.ray_state.position), flight.ray_state, frame_);
    }
    if (const auto trap = trap_of(flight.ray_state, frame_)) {
      flight.trap = *trap;
      waiting_.push_back(flight);
    } else if (record_ != nullptr) {
      TrailEvent& event = record_->trails[flight.ray].events.back();
      event.waits = event.ends = true;
    }
  }

  Termination way(Flight& flight) {
    std::int32_t taken = 0;
    if (record_ != nullptr)
      return run<true>(flight.ray_state, frame_, counters_, record_, &record_->trails[flight.ray]);
    return frame_.plain() ? run_plain(flight.ray_state, frame_, counters_, taken)
                          : run<false>(flight.ray_state, frame_, counters_);
  }

  void end_with(const Flight& flight, Termination how) {
    count_end(flight.ray_state, how, frame_, counters_);
    pack_ended(flight.ray_state, frame_, rays_[flight.ray]);
    ended_[flight.ray] = true;
    if (record_ != nullptr) record_->trails[flight.ray].end();
  }

  std::span<wire::Ray> rays_;
  const Frame& frame_;
  RayCounters& counters_;
  const TrailRecord* record_;  // null: nothing is recorded
  std::vector<bool> ended_;
  std::vector<Flight> waiting_;
};

}  // namespace

void integrate(wire::Ray& ray, const Frame& frame, RayCounters& counters, std::int32_t* steps) {
  RayState ray_state = unpack(ray, frame);
  std::int32_t taken = 0;
  const Termination how =
      frame.plain() ? run_plain(ray_state, frame, counters, taken) : run<false>(ray_state, frame, counters);
  if (steps != nullptr) *steps = taken;
  count_end(ray_state, how, frame, counters);
  pack(ray_state, frame, ray);
}

std::vector<bool> integrate_all(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                                const TrailRecord* record) {
  Flights flights(rays, frame, counters, record);
  for (std::size_t i = 0; i < rays.size(); ++i) flights.begin(i);
  while (flights.are_waiting()) flights.scatter();
  return std::move(flights).ended();
}

}  // namespace gicube::emu
