#include "polygon_gi/program/options.h"

namespace gicube::samples {

std::optional<PolygonGiOptions> parse_polygon_gi_options(int argc, const char* const* argv, std::ostream& out) {
  CLI::App app("Radiosity between a scene's polygons with the medium between them, its rays by a GI-Cube board.",
               "gicube-polygon-gi");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  const auto add = [](OptionGroup& method, PolygonGiOptions& options) {
    method.number("--edge", options.edge, CLI::Range(0.05, 1024.0), "longest edge of a triangle, voxels");
    method.number("--zone", options.settings.zone, CLI::Range(1, 256), "edge of the medium's zones, voxels");
    method.number("--rays", options.settings.rays, CLI::Range(16, 1'000'000), "of each triangle's side and zone");
    method.number("--lamp-rays", options.settings.lamp_rays, CLI::Range(1, 100'000), "of each, to points on emitters");
    method.number("--convergence", options.settings.convergence, CLI::Range(1e-9, 0.1),
                  "greatest change of a radiosity in the last iteration over the greatest radiosity");
    method.number("--passes", options.passes, CLI::Range(1, 1'000'000), "rays a pixel");
  };
  return parse_light_options<PolygonGiOptions>(app, 64, add, argc, argv, out);
}

}  // namespace gicube::samples
