#include "subsurface/program/options.h"

namespace gicube::samples {

std::optional<SubsurfaceOptions> parse_subsurface_options(int argc, const char* const* argv, std::ostream& out) {
  CLI::App app(
      "Measures how a slab of a material spreads light, by photons of a GI-Cube board, and draws a mesh of it.",
      "gicube-subsurface");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  const auto add = [&app](OptionGroup& method, SubsurfaceOptions& options) {
    app.add_option("--material", options.material, "a scene whose world is a slab of it, the top at its greatest z")
        ->required()
        ->type_name("FILE");
    method.file("--profile", options.profile, "the rings' shares and their standard errors, CSV");
    method.value("--node", options.node, "the scene's node that is made of it (the first polygons)")->type_name("NAME");
    method.number("--scale", options.scale, CLI::Range(1e-6, 1e6), "a unit of the slab in units of the scene");
    method.number("--photons", options.settings.photons, CLI::Range(1'000, 1'000'000'000), "into the slab");
    method.number("--rings", options.settings.rings, CLI::Range(1, 10'000), "of the profile");
    method.number("--radius", options.settings.radius, CLI::Range(0.0, 1024.0),
                  "of the outermost ring, voxels of the slab; 0: a quarter of its shorter side");
    method.flag("--straight", options.settings.straight, "light comes straight down, not from the half space");
    method.number("--edge", options.edge, CLI::Range(0.05, 1024.0), "longest edge of a triangle, voxels");
    method.number("--lamp-rays", options.lamp_rays, CLI::Range(1, 100'000), "of each triangle, to points on lamps");
    method.number("--passes", options.passes, CLI::Range(1, 1'000'000), "rays a pixel");
  };
  return parse_light_options<SubsurfaceOptions>(app, 16, add, argc, argv, out);
}

}  // namespace gicube::samples
