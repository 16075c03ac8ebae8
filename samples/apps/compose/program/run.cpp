#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "compose/program/options.h"
#include "gicube/scene/image_file.h"
#include "scene/program/board_run.h"
#include "scene/program/bounds.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

Stage stage_of(const ComposeOptions& options, std::optional<Colour>& background) {
  Composition composition = read_composition(options.composition, options.allow_outside);
  View& view = composition.view;
  if (options.size) view.width = (*options.size)[0], view.height = (*options.size)[1];
  view.samples_per_axis = options.samples_per_axis.value_or(view.samples_per_axis);
  view.step = options.step.value_or(view.step);
  composition.overlap_step = options.overlap_step.value_or(composition.overlap_step);
  background = composition.background;
  return set_up(composition, options.board.threads);
}

std::uint64_t stage_hash(const Stage& stage) {
  std::vector<std::uint64_t> hashes;
  for (const StageMedium& medium : stage.media) hashes.push_back(scene_hash(medium.setup));
  std::uint64_t all = hash_of(std::as_bytes(std::span(hashes)));
  for (const Mesh& mesh : stage.meshes->meshes()) all = hash_of(std::as_bytes(std::span(mesh.points)), all);
  return all;
}

void print(const Stage& stage, const std::vector<MediumCost>& costs) {
  for (std::size_t i = 0; i < costs.size(); ++i) {
    fmt::print("{}: {} rays meet it, {} segments, {:.3f} ms to load, {:.3f} ms to trace, board {}\n",
               stage.media[i].name, costs[i].rays, costs[i].segments, to_ms(costs[i].load), to_ms(costs[i].trace),
               costs[i].board);
  }
  fmt::print("picture: {:.3f} ms simulated, {:.3f} ms for a further one\n", to_ms(time_of(costs, false)),
             to_ms(time_of(costs, true)));
}

// Keys: volumes (name, board, rays, segments, load_ms, trace_ms), surfaces, frame_ms, further_frame_ms, step,
// overlap_step, boards (each as cost_json()).
Json statistics_of(const Stage& stage, const std::vector<MediumCost>& costs) {
  Json volumes = Json::array();
  for (std::size_t i = 0; i < costs.size(); ++i) {
    volumes.push_back({{"name", stage.media[i].name},
                       {"board", costs[i].board},
                       {"rays", costs[i].rays},
                       {"segments", costs[i].segments},
                       {"load_ms", to_ms(costs[i].load)},
                       {"trace_ms", to_ms(costs[i].trace)}});
  }
  return {{"volumes", volumes},
          {"surfaces", stage.surfaces.size()},
          {"frame_ms", to_ms(time_of(costs, false))},
          {"further_frame_ms", to_ms(time_of(costs, true))},
          {"step", stage.view.step},
          {"overlap_step", stage.overlap_step}};
}

}  // namespace

Picoseconds time_of(const std::vector<MediumCost>& costs, bool again) {
  std::vector<std::vector<const MediumCost*>> boards;
  for (const MediumCost& cost : costs) {
    if (boards.size() <= cost.board) boards.resize(cost.board + 1);
    boards[cost.board].push_back(&cost);
  }
  Picoseconds longest = 0;
  for (const auto& volumes : boards) {
    Picoseconds time = 0;
    for (const MediumCost* cost : volumes) time += cost->trace + (again && volumes.size() == 1 ? 0 : cost->load);
    longest = std::max(longest, time);
  }
  return longest;
}

void run(const ComposeOptions& options, ProgressLine& progress) {
  check_outputs({{"--output", options.picture}, {"--stats", options.board.stats}});
  progress.show("reading the composition");
  std::optional<Colour> background;
  const Stage stage = stage_of(options, background);
  std::vector<Board> boards;
  for (int i = 0; i < options.boards; ++i) boards.push_back(open_board(options.board));
  std::vector<RunWindow> windows;
  for (Board& board : boards) windows.emplace_back(board);
  std::vector<MediumCost> costs;
  const Picture picture = compose(stage, boards, costs, progress.parts("tracing"));
  progress.clear();
  if (!options.board.quiet) {
    print(stage, costs);
    for (std::size_t i = 0; i < boards.size(); ++i) {
      fmt::print("board {}: {}\n", i, what_bounds(windows[i].simulated(), windows[i].counters(), boards[i].info()));
    }
    warn_if_invisible(boards.front(), picture.image());
  }
  const Provenance provenance = provenance_of(boards.front().info(), stage_hash(stage));
  if (!options.picture.empty()) {
    const bool own_alpha = options.picture.extension() == ".exr";
    write_image(picture.image(), options.picture, own_alpha ? std::nullopt : background, provenance);
  }
  if (options.board.stats.empty()) return;
  Json json = statistics_of(stage, costs);
  for (std::size_t i = 0; i < boards.size(); ++i) json["boards"].push_back(cost_json(boards[i].info(), windows[i]));
  write_json(json, provenance, options.board.stats);
}

}  // namespace gicube::samples
