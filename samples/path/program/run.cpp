#include <fmt/format.h>

#include <cmath>

#include "gicube/scene/image_file.h"
#include "path/program/options.h"
#include "scene/common/whole_file.h"
#include "scene/program/board_run.h"
#include "scene/program/program.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

struct Noise {
  Rgb mean{};
  double relative = 0;  // root mean square of the pixels' standard errors over the mean radiance of all channels
};

Noise noise_of(const PathPicture& picture) {
  Noise out;
  double squares = 0;
  for (std::size_t i = 0; i < picture.mean.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      out.mean[c] += picture.mean[i][c] / static_cast<double>(picture.mean.size());
      squares += picture.error[i][c] * picture.error[i][c];
    }
  }
  const double all = out.mean[0] + out.mean[1] + out.mean[2];
  out.relative = 3 * std::sqrt(squares / static_cast<double>(3 * picture.mean.size())) / all;
  return out;
}

void write_pixels(const PathPicture& picture, const std::filesystem::path& path) {
  std::string text = "x,y,red,green,blue,red_error,green_error,blue_error\n";
  const auto width = static_cast<std::size_t>(picture.width);
  for (std::size_t i = 0; i < picture.mean.size(); ++i) {
    const Rgb &mean = picture.mean[i], &error = picture.error[i];
    text += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.3g},{:.3g},{:.3g}\n", i % width, i / width, mean[0], mean[1],
                        mean[2], error[0], error[1], error[2]);
  }
  write_whole(path, text);
}

Json or_null(double number) { return std::isfinite(number) ? Json(number) : Json(nullptr); }

}  // namespace

void run(const PathOptions& options, ProgressLine& progress) {
  check_outputs({{"--output", options.light.output}, {"--pixels", options.pixels}, {"--stats", options.board.stats}});
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
  Json cost = cost_json(board.info(), window);
  progress.clear();

  const PathPicture picture = paths.picture();
  const PathStatistics& statistics = paths.statistics();
  const Noise noise = noise_of(picture);
  if (!options.board.quiet) {
    fmt::print("{} paths, {} connections, {} rays; board {:.3f} ms simulated; {:.1f} s\n", statistics.paths,
               statistics.connections, statistics.rays, cost["board_ms"].get<double>(),
               cost["host_seconds"].get<double>());
    fmt::print("mean radiance {:.4g} {:.4g} {:.4g}; standard error of a pixel {:.1f}% of it\n", noise.mean[0],
               noise.mean[1], noise.mean[2], 100 * noise.relative);
  }
  const Provenance provenance = provenance_of(board.info(), scene_hash(setup));
  if (!options.light.output.empty()) {
    const double asked = options.light.exposure;
    const Image image = image_of(picture.width, picture.height, picture.mean, asked);
    write_image(image, options.light.output, Background(), provenance);
  }
  if (!options.pixels.empty()) write_pixels(picture, options.pixels);
  if (options.board.stats.empty()) return;
  Json json{{"paths", statistics.paths},
            {"connections", statistics.connections},
            {"rays", statistics.rays},
            {"passes", picture.passes},
            {"mean_radiance", noise.mean},
            {"relative_error", or_null(noise.relative)},
            {"settings",
             {{"light_scatterings", options.settings.light_scatterings},
              {"max_scatterings", options.settings.max_scatterings},
              {"step", options.settings.step},
              {"seed", options.settings.seed}}}};
  json.update(cost);
  write_json(json, provenance, options.board.stats);
}

}  // namespace gicube::samples
