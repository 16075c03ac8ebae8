#include <fmt/format.h>

#include "path/program/options.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"
#include "transport/program/radiance_report.h"

namespace gicube::samples {

void run(const PathOptions& options, ProgressLine& progress) {
  check_outputs(
      {{"--output", options.light.output}, {"--pixels", options.light.pixels}, {"--stats", options.board.stats}});
  progress.show("reading the scene");
  const SceneSetup setup = set_up_light(options.light, options.board.threads);
  Board board = open_board(options.board);
  check_fits(setup.volume.dims, board.info(), setup.volume.source);
  const Medium medium(board, setup, progress.parts("loading the volume"));
  const Lights lights(setup, medium);
  Bidirectional paths(board, medium, lights, setup.view, options.settings);

  RunWindow window(board);
  const Progress told = progress.parts("paths");
  for (int pass = 0; pass < options.passes; ++pass) {
    paths.pass();
    if (told) told(static_cast<std::uint32_t>(pass + 1), static_cast<std::uint32_t>(options.passes));
  }
  nlohmann::ordered_json cost = cost_json(board.info(), window);
  progress.clear();

  const RadiancePicture picture = paths.picture();
  const PathStatistics& statistics = paths.statistics();
  const Noise noise = noise_of(picture);
  if (!options.board.quiet) {
    fmt::print("{} paths, {} connections, {} rays; board {:.3f} ms simulated; {:.1f} s\n", statistics.paths,
               statistics.connections, statistics.rays, cost["board_ms"].get<double>(),
               cost["host_seconds"].get<double>());
    print(noise);
  }
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  write_pictures(picture, options.light, provenance);
  if (options.board.stats.empty()) return;
  nlohmann::ordered_json json{{"paths", statistics.paths},
                              {"connections", statistics.connections},
                              {"rays", statistics.rays},
                              {"passes", picture.passes},
                              {"mean_radiance", noise.mean},
                              {"relative_error", noise_json(noise)},
                              {"settings",
                               {{"light_scatterings", options.settings.light_scatterings},
                                {"max_scatterings", options.settings.max_scatterings},
                                {"step", options.settings.step},
                                {"seed", options.settings.seed}}}};
  json.update(cost);
  write_json(json, provenance, options.board.stats);
}

}  // namespace gicube::samples
