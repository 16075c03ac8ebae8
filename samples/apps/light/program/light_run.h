// Common part of the methods: their options, their passes on a board, and their reports.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>

#include "light/program/light_input.h"
#include "light/program/radiance_report.h"
#include "light/transport/lights.h"
#include "light/transport/medium.h"
#include "scene/program/board_options.h"
#include "scene/program/board_run.h"
#include "scene/program/option_group.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"

namespace gicube::samples {

template <class Settings>
struct LightOptions {
  LightInput light;
  Settings settings;
  int passes = 0;
  BoardOptions board;
};

// Counts of a run, printed and for --stats.
struct LightCounts {
  std::string text;
  nlohmann::ordered_json json;
};

// A command of gicube-light.
template <class Settings, class Statistics>
struct LightCommand {
  const char* name;
  const char* help;
  const char* paths;  // in the progress line
  int passes;         // default
  void (*add)(OptionGroup& group, LightOptions<Settings>& options);
  nlohmann::ordered_json (*settings_of)(const Settings& settings);  // for --stats
  LightCounts (*counts_of)(const Statistics& statistics);
};

// Throws UsageError, InputError, FileError, and what Board throws.
template <class Method, class Settings, class Statistics>
void run_light(const LightCommand<Settings, Statistics>& command, LightOptions<Settings> options) {
  if (!options.light.output.empty()) check_picture_name(options.light.output);
  options.settings.step = options.light.step;
  options.settings.seed = options.board.seed;
  check_outputs(
      {{"--output", options.light.output}, {"--pixels", options.light.pixels}, {"--stats", options.board.stats}});
  ProgressLine progress(!options.board.quiet);
  progress.show("reading the scene");
  const SceneSetup setup = set_up_light(light_scene(options.light), options.light, options.board.threads);
  Board board = open_board(options.board);
  check_renders(setup.volume.dims, board.info(), setup.volume.source);
  const Medium medium(board, setup, progress.parts("loading the volume"));
  const Lights lights(setup, medium);
  Method method(board, medium, lights, setup.view, options.settings);

  RunWindow window(board);
  const Progress told = progress.parts(command.paths);
  for (int pass = 0; pass < options.passes; ++pass) {
    method.pass();
    if (told) told(static_cast<std::uint32_t>(pass + 1), static_cast<std::uint32_t>(options.passes));
  }
  const nlohmann::ordered_json cost = cost_json(board.info(), window);
  progress.clear();

  const RadiancePicture picture = method.picture();
  auto [text, json] = command.counts_of(method.statistics());
  const Noise noise = noise_of(picture);
  if (!options.board.quiet) {
    fmt::print("{}; board {:.3f} ms simulated; {:.1f} s\n", text, cost["board_ms"].get<double>(),
               cost["host_seconds"].get<double>());
    fmt::print("{}\n", cost["bound"].get<std::string>());
    print(noise);
  }
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  write_pictures(picture, options.light, provenance);
  if (options.board.stats.empty()) return;
  json["passes"] = picture.passes;
  json["mean_radiance"] = noise.mean;
  json["relative_error"] = noise_json(noise);
  json["settings"] = command.settings_of(options.settings);
  json.update(cost);
  write_json(json, provenance, options.board.stats);
}

template <class Method, class Settings, class Statistics>
void add_light(CLI::App& program, const LightCommand<Settings, Statistics>& command) {
  CLI::App& app = *program.add_subcommand(command.name, command.help);
  const auto options = std::make_shared<LightOptions<Settings>>();
  options->passes = command.passes;
  add_light_input(app, options->light);
  OptionGroup method(app, "Method");
  command.add(method, *options);
  add_board_options(app, options->board);
  app.callback([command, options] { run_light<Method>(command, *options); });
}

}  // namespace gicube::samples
