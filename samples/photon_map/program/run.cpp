#include <fmt/format.h>

#include "photon_map/program/options.h"
#include "transport/program/light_run.h"

namespace gicube::samples {

void run(const PhotonOptions& options, ProgressLine& progress) {
  const auto& settings = options.settings;
  const auto counts = [](const auto& statistics) {
    return LightCounts{fmt::format("{} photons sent, {} kept on surfaces, {} in media; {} rays", statistics.emitted,
                                   statistics.on_surfaces, statistics.in_media, statistics.rays),
                       {{"photons", statistics.emitted},
                        {"on_surfaces", statistics.on_surfaces},
                        {"in_media", statistics.in_media},
                        {"rays", statistics.rays}}};
  };
  const nlohmann::ordered_json settings_json{
      {"photons", settings.photons}, {"neighbours", settings.neighbours},
      {"radius", settings.radius},   {"max_scatterings", settings.max_scatterings},
      {"step", settings.step},       {"seed", settings.seed}};
  run_light<PhotonMapping>(options, "photons", settings_json, counts, progress);
}

}  // namespace gicube::samples
