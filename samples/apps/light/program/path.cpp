#include "light/path/bidirectional.h"
#include "light/program/light_run.h"
#include "light/program/methods.h"

namespace gicube::samples {
namespace {

using PathOptions = LightOptions<BidirectionalSettings>;

void add_path_options(OptionGroup& group, PathOptions& options) {
  group.number("--passes", options.passes, CLI::Range(1, 1'000'000), "paths per pixel");
  group.number("--light-scatterings", options.settings.light_scatterings, CLI::Range(0, 64),
               "scatterings of a path from a light, at most; 0: connect only paths from the eye with lights");
  group.number("--max-scatterings", options.settings.max_scatterings, CLI::Range(1, 1024),
               "scatterings of a whole path; light that scatters more often is missing");
}

nlohmann::ordered_json path_settings(const BidirectionalSettings& settings) {
  return {{"light_scatterings", settings.light_scatterings},
          {"max_scatterings", settings.max_scatterings},
          {"step", settings.step},
          {"seed", settings.seed}};
}

LightCounts path_counts(const PathStatistics& statistics) {
  return {fmt::format("{} paths, {} connections, {} rays", statistics.paths, statistics.connections, statistics.rays),
          {{"paths", statistics.paths}, {"connections", statistics.connections}, {"rays", statistics.rays}}};
}

}  // namespace

void add_path(CLI::App& program) {
  add_light<Bidirectional, BidirectionalSettings, PathStatistics>(
      program, {"path", "bidirectional path tracing", "paths", 16, add_path_options, path_settings, path_counts});
}

}  // namespace gicube::samples
