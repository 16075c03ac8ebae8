#include <fmt/format.h>

#include <optional>
#include <utility>

#include "form_factors/program/options.h"
#include "form_factors/radiosity/field.h"
#include "gicube/scene/image_file.h"
#include "scene/program/board_run.h"
#include "scene/program/bounds.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

void print(const RadiosityResult& result) {
  const RadiosityStatistics& s = result.statistics;
  fmt::print(
      "{} faces, {} medium, {} of the volume's ends; {} links where a full matrix has {} ({:.1f} times as many)\n",
      s.faces, s.medium, s.ends, s.links, s.all_pairs,
      s.links > 0 ? static_cast<double>(s.all_pairs) / static_cast<double>(s.links) : 0);
  fmt::print("{} pairs, {} rays; board {:.3f} ms simulated, bus {:.2f} MB down, {:.2f} MB up; {:.1f} s\n", s.pairs,
             s.rays, to_ms(s.board_time), static_cast<double>(s.bus_down_bytes) * 1e-6,
             static_cast<double>(s.bus_up_bytes) * 1e-6, s.host_seconds);
  for (std::size_t i = 0; i < s.iterations.size(); ++i) {
    if (i >= 3 && i + 1 < s.iterations.size() && s.iterations[i].links == s.iterations[i + 1].links) continue;
    fmt::print("iteration {}: {} links, {:.2g} under way\n", i + 1, s.iterations[i].links, s.iterations[i].residual);
  }
  const EnergyBalance& e = s.energy;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!(e.emitted[c] > 0)) continue;
    const auto percent = [&](double power) { return 100 * power / e.emitted[c]; };
    fmt::print("{}: {:.2f}% in faces, {:.2f}% in medium, {:.2f}% escaped, {:.3f}% under way, {:.3f}% missing\n",
               std::array{"red", "green", "blue"}[c], percent(e.absorbed_by_faces[c]), percent(e.absorbed_by_medium[c]),
               percent(e.escaped[c]), percent(e.under_way[c]), percent(e.closure[c]));
  }
}

void draw(const SolveOptions& options, const Scene& scene, const SceneSetup& setup, const LightField& field,
          Board& board, ProgressLine& progress) {
  load(board, setup, false, progress.parts("loading the volume"));
  for (std::size_t tag = 0; tag < setup.optics.size(); ++tag) {
    board.set_material(setup.optics[tag], static_cast<int>(tag));
  }
  board.set_shading({scene.phong.value_or(Phong{.ambient = 0, .diffuse = 1, .specular = 0}), setup.shading.light});
  const double asked = options.exposure > 0 ? options.exposure : scene.lighting.exposure;
  const double exposure = asked > 0 ? asked : exposure_for(field);
  const bool own_alpha = options.picture.extension() == ".exr";
  const auto background = own_alpha ? std::nullopt : setup.background;
  const Image image = picture_of(board, field, setup.view, exposure, background, progress.parts("picture"));
  write_image(image, options.picture, background, provenance_of(board.info(), scene_hash(setup)));
  progress.clear();
  if (options.board.quiet) return;
  fmt::print("{}: exposure {:.4g}\n", options.picture.string(), exposure);
  warn_if_invisible(board, image);
}

}  // namespace

Emissions emissions_of(const SceneSetup& setup) {
  Emissions emissions(setup.emissions.size());
  for (std::size_t tag = 0; tag < emissions.size(); ++tag) {
    const MaterialLook& look = setup.looks[tag];
    if (!std::holds_alternative<FogLook>(look)) emissions[tag].surface = setup.emissions[tag];
    if (std::holds_alternative<SolidLook>(look)) continue;
    add(emissions[tag].volume, setup.grid.voxel, setup.emissions[tag]);  // of a cubic voxel, over its faces' area
  }
  return emissions;
}

void run(const SolveOptions& options, ProgressLine& progress) {
  const bool factors = !options.factors.empty();
  check_outputs({{"--factors", options.factors},
                 {"--factors", factors ? clusters_file(options.factors) : std::filesystem::path()},
                 {"--elements", options.elements},
                 {"--solution", options.solution},
                 {"--output", options.picture},
                 {"--stats", options.board.stats}},
                {options.input.input, options.input.transfer_function});
  progress.show("reading the scene");
  Scene scene = scene_of(options.input);
  set_materials(options, scene);
  if (!options.camera_name.empty()) choose_camera(scene, options.camera_name);
  if (options.size) scene.view.width = (*options.size)[0], scene.view.height = (*options.size)[1];
  scene.lighting.on = false;
  const SceneSetup setup = set_up(scene, options.board.threads);
  Board board = open_board(board_for(options.plan, options.board));
  check_renders(setup.volume.dims, board.info(), setup.volume.source);

  RunWindow window(board);
  const Emissions emissions = emissions_of(setup);
  const auto told = [&progress](std::string_view what, double share) {
    progress.show(fmt::format("{} {:.0f}%", what, 100 * share));
  };
  std::optional<RadiosityPlan> plan;
  if (options.plan.wanted()) {
    plan = plan_radiosity(board, setup, emissions, options.settings, options.plan.target(), told);
  }
  const RadiositySettings& settings = plan ? plan->settings : options.settings;
  const RadiosityResult result =
      plan ? std::move(plan->result) : solve_radiosity(board, setup, emissions, settings, told);
  const Counters counters = window.counters();
  progress.clear();
  if (plan && options.plan.explain) print_plan(plan->explain());
  if (!options.board.quiet) {
    print(result);
    fmt::print("{}\n", what_bounds(result.statistics.board_time, counters, board.info()));
  }
  if (!options.factors.empty()) write_factors(result, options.factors);
  if (!options.elements.empty()) write_elements(result, options.elements);
  const LightField field = field_of(result, setup);
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  if (!options.solution.empty()) {
    write_light_field(field, setup.grid.voxel * setup.volume.spacing, setup.grid.low, options.solution, provenance);
  }
  if (!options.board.stats.empty()) {
    const double voxel = setup.grid.voxel;
    write_json(statistics_of(result, settings, voxel * voxel, counters, board.info(), plan), provenance,
               options.board.stats);
  }
  if (!options.picture.empty()) draw(options, scene, setup, field, board, progress);
}

}  // namespace gicube::samples
