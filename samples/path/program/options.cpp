#include "path/program/options.h"

namespace gicube::samples {

std::optional<PathOptions> parse_path_options(int argc, const char* const* argv, std::ostream& out) {
  CLI::App app("Bidirectional path tracing in a volume, its rays by a GI-Cube board.", "gicube-path");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  const auto add = [](OptionGroup& method, PathOptions& options) {
    method.number("--passes", options.passes, CLI::Range(1, 1'000'000), "paths a pixel");
    method.number("--light-scatterings", options.settings.light_scatterings, CLI::Range(0, 64),
                  "of a light's path, at most; 0: paths from the eye alone, connected with the lights");
    method.number("--max-scatterings", options.settings.max_scatterings, CLI::Range(1, 1024),
                  "of a whole path: light that was scattered more often is missing");
  };
  return parse_light_options<PathOptions>(app, 16, add, argc, argv, out);
}

}  // namespace gicube::samples
