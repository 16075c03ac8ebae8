#include "photon_map/program/options.h"

#include "scene/program/option_group.h"

namespace gicube::samples {

std::optional<PhotonOptions> parse_photon_options(int argc, const char* const* argv, std::ostream& out) {
  PhotonOptions options;
  CLI::App app("Photon mapping in a volume, its photons by a GI-Cube board.", "gicube-photon-map");
  app.footer("Exit codes: 0 done, 1 failed, 2 wrong usage. Method, limits and figures: docs/guide/light_paths.md.");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  add_light_input(app, options.light);
  OptionGroup method(app, "Method");
  method.number("--photons", options.settings.photons, CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}),
                "sent from the lights in each pass");
  method.number("--neighbours", options.settings.neighbours, CLI::Range(2, 10'000), "photons that a density is of");
  method.number("--radius", options.settings.radius, CLI::Range(1e-3, 1e4),
                "of the ball that they may lie in, at most; smallest voxel edges");
  method.number("--passes", options.passes, CLI::Range(1, 1'000'000), "photon maps, and paths a pixel");
  method.number("--max-scatterings", options.settings.max_scatterings, CLI::Range(1, 1024), "of a photon");
  add_board_options(app, options.board);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  check(options.light);
  options.settings.step = options.light.step;
  options.settings.seed = options.board.seed;
  return options;
}

}  // namespace gicube::samples
