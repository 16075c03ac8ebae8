#include "functional.h"

#include <algorithm>
#include <utility>

#include "datapath/bricks.h"
#include "datapath/interaction.h"
#include "datapath/ray_step.h"
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
Termination iterate(RayState& ray_state, const BlockGrid& grid, const Frame& frame, RayCounters& counters,
                    const KnownInterval* known = nullptr) {
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
  const Interaction interaction = sample(ray_state, {at, view, block, edge}, frame, counters, known);
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
    how = iterate(ray_state, grid, frame, counters);
  }
  return how;
}

// Traces rays until they end, are trapped or wait for a block.
class PathTracer {
 public:
  PathTracer(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters, const SimdTracer* tracer,
             std::span<const std::uint64_t> indices)
      : rays_(rays), frame_(frame), counters_(counters), tracer_(tracer), indices_(indices), ended_(rays.size()) {}

  std::vector<bool> run() && {
    std::vector<TracedPath> paths, traps;
    paths.reserve(rays_.size());
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const TracedPath path(i, begin_or_go_on(rays_[i], index_of(i), frame_));
      (waited_trapped(i) ? traps : paths).push_back(path);
    }
    for (TracedPath& path : traps) path.how = Termination::kWaits;
    while (!paths.empty() || !traps.empty()) {
      trace_all(paths);
      paths.insert(paths.end(), traps.begin(), traps.end());
      traps.clear();
      paths = scattered(trapped(paths));
    }
    return std::move(ended_);
  }

 private:
  void trace_all(std::span<TracedPath> paths) {
    if (tracer_ != nullptr) return tracer_->trace_paths(paths, frame_, counters_);
    for (TracedPath& path : paths) trace_path(path, frame_, counters_);
  }

  std::uint64_t index_of(std::size_t ray) const { return indices_.empty() ? ray : indices_[ray]; }
  bool waited_trapped(std::size_t ray) const {
    const WaitingRay* const waited = frame_.in_bricks() ? frame_.waiting->find(index_of(ray)) : nullptr;
    return waited != nullptr && waited->trapped;
  }
  std::size_t block_of(const TracedPath& path) const {
    return BlockGrid(*frame_.volume).block(path.ray_state.position);
  }
  void wait(const TracedPath& path, bool is_trapped) {
    const auto block = static_cast<std::uint32_t>(block_of(path));
    frame_.waiting->add({.ray_state = path.ray_state, .block = block, .trapped = is_trapped}, index_of(path.ray));
  }

  // Returns the paths that a routine answers; completes the others.
  std::vector<TracedPath> trapped(std::span<TracedPath> paths) {
    std::vector<TracedPath> out;
    for (TracedPath& path : paths) {
      if (path.how == Termination::kNonResident) {
        wait(path, false);
      } else if (path.how != Termination::kWaits) {
        end_with(path, path.how);
      } else if (is_non_resident_for_routine(block_of(path), frame_)) {
        wait(path, true);
      } else if (const auto trap = trap_of(path.ray_state, frame_)) {
        path.trap = *trap;
        out.push_back(path);
      }
    }
    return out;
  }

  // Scatters the paths by their routines. Returns those that continue.
  std::vector<TracedPath> scattered(std::vector<TracedPath> paths) {
    std::stable_sort(paths.begin(), paths.end(),
                     [](const TracedPath& a, const TracedPath& b) { return a.trap.routine < b.trap.routine; });
    std::vector<ScatterEvent> events;
    for (const TracedPath& path : paths) events.push_back(path.trap.event);
    std::vector<ScatterAnswer> answers(events.size());
    for (std::size_t first = 0, last = 0; first < paths.size(); first = last) {
      const std::uint8_t routine = paths[first].trap.routine;
      while (last < paths.size() && paths[last].trap.routine == routine) ++last;
      frame_.routines->scatter_all(routine, std::span(events).subspan(first, last - first),
                                   std::span(answers).subspan(first, last - first));
    }
    std::vector<TracedPath> out;
    for (std::size_t i = 0; i < paths.size(); ++i) {
      const Interaction interaction = answer_trap(paths[i].ray_state, answers[i], frame_, counters_);
      if (interaction.outcome == Outcome::kEnded) {
        end_with(paths[i], Termination::kAbsorbed);
      } else {
        out.push_back(paths[i]);
      }
    }
    return out;
  }

  void end_with(const TracedPath& path, Termination how) {
    count_end(path.ray_state, how, frame_, counters_);
    pack_ended(path.ray_state, frame_, rays_[path.ray]);
    ended_[path.ray] = true;
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

Termination take_iteration(RayState& ray_state, const Frame& frame, RayCounters& counters, const KnownInterval* known) {
  return iterate(ray_state, BlockGrid(*frame.volume), frame, counters, known);
}

void trace_path(TracedPath& path, const Frame& frame, RayCounters& counters) {
  std::int32_t taken = 0;
  path.how = frame.plain() ? run_plain(path.ray_state, frame, counters, taken) : run(path.ray_state, frame, counters);
}

std::vector<bool> integrate_all(std::span<wire::Ray> rays, const Frame& frame, RayCounters& counters,
                                const SimdTracer* tracer, std::span<const std::uint64_t> indices) {
  return PathTracer(rays, frame, counters, tracer, indices).run();
}

}  // namespace gicube::emu
