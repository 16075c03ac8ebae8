#include "form_factors/program/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <ostream>

#include "gicube/scene/error.h"
#include "gicube/scene/scene.h"
#include "scene/common/checks.h"
#include "scene/program/option_group.h"
#include "scene/program/program.h"

namespace gicube::samples {
namespace {

const CLI::Range kShares(1e-12, 1.0), kSteps(1.0 / 64, 16.0), kLeafVoxels(1, 1024);

// "2=5" or "2=5,4,3".
SolveOptions::ByTag by_tag(const std::string& option, const std::string& text, double most) {
  const auto bad = [&] {
    return CLI::ValidationError(option,
                                fmt::format("expected TAG=VALUE or TAG=RED,GREEN,BLUE with a tag from 0 to 3 and "
                                            "numbers from 0{}, got {}",
                                            most < 1e300 ? fmt::format(" to {}", most) : "", in_quotes(text)));
  };
  const std::size_t equals = text.find('=');
  if (equals != 1 || text[0] < '0' || text[0] > '3') throw bad();
  const std::string numbers = text.substr(2);
  const bool coloured = numbers.find(',') != std::string::npos;
  const std::vector<double> values = parse_numbers(option, numbers, coloured ? 3 : 1);
  for (const double value : values) {
    if (!(value >= 0 && value <= most)) throw bad();
  }
  return {text[0] - '0', {values[0], values[coloured ? 1 : 0], values[coloured ? 2 : 0]}};
}

void add_materials(CLI::App& app, SolveOptions& options) {
  OptionGroup group(app, "Scene");
  const auto add = [&](const char* option, const char* type, const char* help, double most, auto& values) {
    group
        .parsed(option, type, help,
                [most, &values](const std::string& name, const std::string& text) {
                  values.push_back(by_tag(name, text, most));
                })
        ->take_all();
  };
  add("--emission", "TAG=POWER",
      "replace a tag's emission, per unit of surface (or of a fog's volume), as 2=5 or 2=5,4,3 for red, green and "
      "blue; "
      "repeatable",
      std::numeric_limits<double>::infinity(), options.emissions);
  add("--albedo", "TAG=SHARE", "replace a tag's albedo, 0..1; likewise", 1, options.albedos);
}

void add_made(OptionGroup& group, PairRays& made) {
  group.choice("--made", made, kPairRays,
               "where rays are made: board (its DSP, from pair lists) or host (sent over the bus); results are the "
               "same (board)");
}

void add_method(CLI::App& app, RadiositySettings& settings) {
  OptionGroup group(app, "Method");
  group.number("--error", settings.error, kShares, "refine links that may misplace more than this share of all power");
  group.number("--rays", settings.rays, CLI::Range(8, 65536), "rays of a link's first estimate");
  group.number("--max-rays", settings.max_rays, CLI::Range(8, 1 << 24),
               "rays of a link that can't be divided, at most");
  group.number("--step", settings.step, kSteps, "step of the rays, voxels");
  group.number("--solid-opacity", settings.solid_opacity, CLI::Range(1e-6, 1.0),
               "least opacity of one voxel length in a solid; less is medium");
  group.number("--leaf-voxels", settings.leaf_voxels, kLeafVoxels,
               "edge of the cubes that are not divided, voxels: 1, 2, 4, ...");
  group.choice("--solver", settings.solver, kSolvers, "solver (gathering)");
  group.number("--convergence", settings.convergence, kShares,
               "share of all power that may be in transit when the solver stops");
  group.number("--iterations", settings.max_iterations, CLI::Range(1, 1'000'000), "iterations of the solver, at most");
  app.add_flag_callback(
         "--full-matrix", [&settings] { settings.hierarchy = false; },
         "use a link for each pair of elements, without a hierarchy")
      ->group("Method");
  add_made(group, settings.made);
}

void add_output(CLI::App& app, SolveOptions& options) {
  OptionGroup group(app, "Output");
  group.file("--factors", options.factors,
             "write exchange areas here, Matrix Market, and their rows to FILE.clusters.csv");
  group.file("--elements", options.elements, "write the incident light of each element here, CSV");
  group.file("--solution", options.solution,
             "write the incident light of each voxel here, NRRD of three channels for gicube-render --irradiance");
  group.file("-o,--output", options.picture, "write a picture in that light here, PNG or EXR");
  group.value("--camera", options.camera_name, "name of the scene's camera to use (the first)")->type_name("NAME");
  group.size("--size", options.size, "size of the picture, pixels (the scene's)");
  group.number("--exposure", options.exposure, CLI::Range(0.0, 1e12),
               "brightness of a unit of light per unit of area; 0: chosen");
}

void add_visibility(CLI::App& app, VisibilityOptions& options) {
  OptionGroup group(app, "Pairs");
  group.number("--pairs", options.pairs, CLI::Range(1u, 100'000'000u), "pairs of random voxels");
  group.number("--rays", options.rays, CLI::Range(1, 65536), "rays per pair, between random points of both voxels");
  group.number("--step", options.step, kSteps, "step of the rays, voxels");
  add_made(group, options.made);
  group.file("--pairs-file", options.pairs_file, "write each pair's boxes and transmittance here, CSV");
}

void check_solve(SolveOptions& options) {
  if (!options.picture.empty()) check_picture_name(options.picture);
  const RadiositySettings& settings = options.settings;
  if (settings.max_rays < settings.rays) {
    throw UsageError(fmt::format("--max-rays: expected {} (--rays) or more, got {}", settings.rays, settings.max_rays));
  }
  if ((settings.leaf_voxels & (settings.leaf_voxels - 1)) != 0) {
    throw UsageError(fmt::format("--leaf-voxels: expected a power of two, got {}", settings.leaf_voxels));
  }
  options.settings.seed = static_cast<std::uint32_t>(options.board.seed);
}

}  // namespace

std::optional<FormFactorOptions> parse_form_factor_options(int argc, const char* const* argv, std::ostream& out) {
  SolveOptions solve;
  VisibilityOptions visibility;
  CLI::App app("Compute radiosity in volumes, with form factors from a GI-Cube board.", "gicube-form-factors");
  app.footer("Exit codes: 0 done, 1 failed, 2 wrong usage. Method, limits and figures: docs/guide/form_factors.md.");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  app.require_subcommand(1);
  CLI::App* const solving = app.add_subcommand("solve", "compute the light of a scene's emitters on all elements");
  CLI::App* const looking =
      app.add_subcommand("visibility", "measure transmittances between random voxels, and their cost");
  add_scene_input(*solving, solve.input);
  add_materials(*solving, solve);
  add_method(*solving, solve.settings);
  add_output(*solving, solve);
  add_plan_options(*solving, solve.plan, "the solution's pairs");
  add_board_options(*solving, solve.board);
  add_scene_input(*looking, visibility.input);
  add_visibility(*looking, visibility);
  add_board_options(*looking, visibility.board);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  if (looking->parsed()) return visibility;
  check_solve(solve);
  check_plan(solve.plan);
  for (const char* chosen : {"--error", "--rays", "--leaf-voxels", "--full-matrix"}) {
    if (solve.plan.wanted()) refuse_with_plan(*solving, chosen);
  }
  return solve;
}

void set_materials(const SolveOptions& options, Scene& scene) {
  const auto of_tag = [&scene](int tag) -> SceneMaterial& {
    const auto found = std::ranges::find(scene.materials, tag, &SceneMaterial::tag);
    if (found != scene.materials.end()) return *found;
    SceneMaterial made;
    made.name = "tag " + std::to_string(tag);
    made.tag = tag;
    return scene.materials.emplace_back(std::move(made));
  };
  const auto put = [](const Power& value, double& most, Colour& colour) {
    most = std::ranges::max(value);
    for (std::size_t c = 0; c < 3; ++c) colour[c] = most > 0 ? value[c] / most : 1;
  };
  for (const auto& emission : options.emissions) {
    SceneMaterial& material = of_tag(emission.tag);
    put(emission.value, material.emission, material.emission_colour);
  }
  for (const auto& albedo : options.albedos) {
    SceneMaterial& material = of_tag(albedo.tag);
    put(albedo.value, material.optics.scattering, material.scattering_colour);
    if (material.optics.bsdf == Bsdf::kNone) material.optics.bsdf = Bsdf::kDiffuse;
  }
}

}  // namespace gicube::samples
