#include <fmt/format.h>

#include "photon_map/program/options.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"
#include "transport/program/radiance_report.h"

namespace gicube::samples {

void run(const PhotonOptions& options, ProgressLine& progress) {
  check_outputs(
      {{"--output", options.light.output}, {"--pixels", options.light.pixels}, {"--stats", options.board.stats}});
  progress.show("reading the scene");
  const SceneSetup setup = set_up_light(options.light, options.board.threads);
  Board board = open_board(options.board);
  check_fits(setup.volume.dims, board.info(), setup.volume.source);
  const Medium medium(board, setup, progress.parts("loading the volume"));
  const Lights lights(setup, medium);
  PhotonMapping photons(board, medium, lights, setup.view, options.settings);

  RunWindow window(board);
  const Progress told = progress.parts("photons");
  for (int pass = 0; pass < options.passes; ++pass) {
    photons.pass();
    if (told) told(static_cast<std::uint32_t>(pass + 1), static_cast<std::uint32_t>(options.passes));
  }
  nlohmann::ordered_json cost = cost_json(board.info(), window);
  progress.clear();

  const RadiancePicture picture = photons.picture();
  const PhotonStatistics& statistics = photons.statistics();
  const Noise noise = noise_of(picture);
  if (!options.board.quiet) {
    fmt::print("{} photons sent, {} kept on surfaces, {} in media; {} rays; board {:.3f} ms simulated; {:.1f} s\n",
               statistics.emitted, statistics.on_surfaces, statistics.in_media, statistics.rays,
               cost["board_ms"].get<double>(), cost["host_seconds"].get<double>());
    print(noise);
  }
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  write_pictures(picture, options.light, provenance);
  if (options.board.stats.empty()) return;
  nlohmann::ordered_json json{{"photons", statistics.emitted},
                              {"on_surfaces", statistics.on_surfaces},
                              {"in_media", statistics.in_media},
                              {"rays", statistics.rays},
                              {"passes", picture.passes},
                              {"mean_radiance", noise.mean},
                              {"relative_error", noise_json(noise)},
                              {"settings",
                               {{"photons", options.settings.photons},
                                {"neighbours", options.settings.neighbours},
                                {"radius", options.settings.radius},
                                {"max_scatterings", options.settings.max_scatterings},
                                {"step", options.settings.step},
                                {"seed", options.settings.seed}}}};
  json.update(cost);
  write_json(json, provenance, options.board.stats);
}

}  // namespace gicube::samples
