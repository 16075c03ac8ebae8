#include "path/program/options.h"

#include "scene/program/option_group.h"

namespace gicube::samples {

std::optional<PathOptions> parse_path_options(int argc, const char* const* argv, std::ostream& out) {
  PathOptions options;
  CLI::App app("Bidirectional path tracing in a volume, its rays by a GI-Cube board.", "gicube-path");
  app.footer("Exit codes: 0 done, 1 failed, 2 wrong usage. Method, limits and figures: docs/guide/light_paths.md.");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  add_light_input(app, options.light);
  OptionGroup method(app, "Method");
  method.number("--passes", options.passes, CLI::Range(1, 1'000'000), "paths a pixel");
  method.number("--light-scatterings", options.settings.light_scatterings, CLI::Range(0, 64),
                "of a light's path, at most; 0: paths from the eye alone, connected with the lights");
  method.number("--max-scatterings", options.settings.max_scatterings, CLI::Range(1, 1024),
                "of a whole path: light that was scattered more often is missing");
  add_board_options(app, options.board);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  check(options.light);
  options.settings.step = options.light.step;
  options.settings.seed = options.board.seed;
  return options;
}

}  // namespace gicube::samples
