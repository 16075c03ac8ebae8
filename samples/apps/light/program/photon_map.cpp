#include "light/photon_map/photon_map.h"
#include "light/program/light_run.h"
#include "light/program/methods.h"

namespace gicube::samples {
namespace {

using PhotonOptions = LightOptions<PhotonSettings>;

void add_photon_options(OptionGroup& group, PhotonOptions& options) {
  group.number("--photons", options.settings.photons, CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}),
               "photons from the lights per pass");
  group.number("--neighbours", options.settings.neighbours, CLI::Range(2, 10'000), "photons per density estimate");
  group.number("--radius", options.settings.radius, CLI::Range(1e-3, 1e4),
               "greatest radius of the ball around these photons, smallest voxel edges");
  group.number("--passes", options.passes, CLI::Range(1, 1'000'000), "photon maps, and paths per pixel");
  group.number("--max-scatterings", options.settings.max_scatterings, CLI::Range(1, 1024),
               "scatterings of a photon, at most");
}

nlohmann::ordered_json photon_settings(const PhotonSettings& settings) {
  return {{"photons", settings.photons}, {"neighbours", settings.neighbours},
          {"radius", settings.radius},   {"max_scatterings", settings.max_scatterings},
          {"step", settings.step},       {"seed", settings.seed}};
}

LightCounts photon_counts(const PhotonStatistics& statistics) {
  if (4 * statistics.beyond_faces > statistics.looks_in_media) {
    warn(
        fmt::format("{}% of the balls of neighbouring photons reach beyond the volume's faces, where there are no "
                    "photons: media are too dark there; use more --photons or a smaller --radius",
                    100 * statistics.beyond_faces / statistics.looks_in_media));
  }
  return {fmt::format("{} photons sent, {} kept on surfaces, {} in media; {} rays", statistics.emitted,
                      statistics.on_surfaces, statistics.in_media, statistics.rays),
          {{"photons", statistics.emitted},
           {"on_surfaces", statistics.on_surfaces},
           {"in_media", statistics.in_media},
           {"rays", statistics.rays}}};
}

}  // namespace

void add_photon_map(CLI::App& program) {
  add_light<PhotonMapping, PhotonSettings, PhotonStatistics>(
      program, {"photon-map", "photon mapping, for caustics and light in media", "photons", 8, add_photon_options,
                photon_settings, photon_counts});
}

}  // namespace gicube::samples
