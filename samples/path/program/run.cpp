#include <fmt/format.h>

#include "path/program/options.h"
#include "transport/program/light_run.h"

namespace gicube::samples {

void run(const PathOptions& options, ProgressLine& progress) {
  const auto& settings = options.settings;
  const auto counts = [](const auto& statistics) {
    return LightCounts{
        fmt::format("{} paths, {} connections, {} rays", statistics.paths, statistics.connections, statistics.rays),
        {{"paths", statistics.paths}, {"connections", statistics.connections}, {"rays", statistics.rays}}};
  };
  const nlohmann::ordered_json settings_json{{"light_scatterings", settings.light_scatterings},
                                             {"max_scatterings", settings.max_scatterings},
                                             {"step", settings.step},
                                             {"seed", settings.seed}};
  run_light<Bidirectional>(options, "paths", settings_json, counts, progress);
}

}  // namespace gicube::samples
