// What gicube-path and gicube-photon-map do alike: passes of light on a board, and what is said and written of them.
#pragma once

#include <fmt/format.h>

#include <string>

#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"
#include "transport/lights.h"
#include "transport/medium.h"
#include "transport/program/light_options.h"
#include "transport/program/radiance_report.h"

namespace gicube::samples {

// What a run has counted: as it is printed, and for --stats.
struct LightCounts {
  std::string text;
  nlohmann::ordered_json json;
};

// `what`: the method's paths, for the progress line. `settings_json`: what --stats has of the settings. `counts_of`: makes LightCounts of
// Method's statistics. Throws UsageError, InputError, FileError, and what Board throws.
template <class Method, class Settings, class CountsOf>
void run_light(const LightOptions<Settings>& options, const std::string& what,
               const nlohmann::ordered_json& settings_json, const CountsOf& counts_of, ProgressLine& progress) {
  check_outputs(
      {{"--output", options.light.output}, {"--pixels", options.light.pixels}, {"--stats", options.board.stats}});
  progress.show("reading the scene");
  const SceneSetup setup = set_up_light(light_scene(options.light), options.light, options.board.threads);
  Board board = open_board(options.board);
  check_renders(setup.volume.dims, board.info(), setup.volume.source);
  const Medium medium(board, setup, progress.parts("loading the volume"));
  const Lights lights(setup, medium);
  Method method(board, medium, lights, setup.view, options.settings);

  RunWindow window(board);
  const Progress told = progress.parts(what);
  for (int pass = 0; pass < options.passes; ++pass) {
    method.pass();
    if (told) told(static_cast<std::uint32_t>(pass + 1), static_cast<std::uint32_t>(options.passes));
  }
  const nlohmann::ordered_json cost = cost_json(board.info(), window);
  progress.clear();

  const RadiancePicture picture = method.picture();
  auto [text, json] = counts_of(method.statistics());
  const Noise noise = noise_of(picture);
  if (!options.board.quiet) {
    fmt::print("{}; board {:.3f} ms simulated; {:.1f} s\n", text, cost["board_ms"].get<double>(),
               cost["host_seconds"].get<double>());
    print(noise);
  }
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  write_pictures(picture, options.light, provenance);
  if (options.board.stats.empty()) return;
  json["passes"] = picture.passes;
  json["mean_radiance"] = noise.mean;
  json["relative_error"] = noise_json(noise);
  json["settings"] = settings_json;
  json.update(cost);
  write_json(json, provenance, options.board.stats);
}

}  // namespace gicube::samples
