#include "photon_map/program/options.h"

namespace gicube::samples {

std::optional<PhotonOptions> parse_photon_options(int argc, const char* const* argv, std::ostream& out) {
  CLI::App app("Photon mapping in a volume, its photons by a GI-Cube board.", "gicube-photon-map");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  const auto add = [](OptionGroup& method, PhotonOptions& options) {
    method.number("--photons", options.settings.photons, CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}),
                  "sent from the lights in each pass");
    method.number("--neighbours", options.settings.neighbours, CLI::Range(2, 10'000), "photons that a density is of");
    method.number("--radius", options.settings.radius, CLI::Range(1e-3, 1e4),
                  "of the ball that they may lie in, at most; smallest voxel edges");
    method.number("--passes", options.passes, CLI::Range(1, 1'000'000), "photon maps, and paths a pixel");
    method.number("--max-scatterings", options.settings.max_scatterings, CLI::Range(1, 1024), "of a photon");
  };
  return parse_light_options<PhotonOptions>(app, 8, add, argc, argv, out);
}

}  // namespace gicube::samples
