#include "render/statistics.h"

#include <fmt/format.h>

#include <fstream>

#include "common/input_error.h"

namespace gicube::samples {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(Fidelity fidelity) {
  switch (fidelity) {
    case Fidelity::kFunctional: return "functional";
    case Fidelity::kApproximate: return "approximate";
    case Fidelity::kCycle: return "cycle";
  }
  return "unknown";
}

Json counter_or_null(const Counters& counters, const char* name) {
  return counters.has(name) ? Json(counters.value(name)) : Json(nullptr);
}

// Samples of a simulated second: the functional level gives its pipelines no time.
Json samples_per_second(const FrameStatistics& statistics) {
  if (statistics.board.fidelity == Fidelity::kFunctional || statistics.frame == 0) return nullptr;
  if (!statistics.counters.has("pipeline.samples")) return nullptr;
  return static_cast<double>(statistics.counters.value("pipeline.samples")) / (to_ms(statistics.frame) * 1e-3);
}

}  // namespace

double bus_ms(const Counters& counters) {
  return to_ms(counters.value("bus.down.busy_ps") + counters.value("bus.up.busy_ps"));
}

Json to_json(const FrameStatistics& statistics) {
  Json json;
  json["frame_ms"] = to_ms(statistics.frame);
  json["load_ms"] = to_ms(statistics.load);
  json["bus_ms"] = bus_ms(statistics.counters);
  json["host_seconds"] = statistics.host_seconds;
  json["samples"] = counter_or_null(statistics.counters, "pipeline.samples");
  json["samples_per_second"] = samples_per_second(statistics);
  // These need the caches and memories of a level that keeps time in the pipelines.
  for (const char* key : {"throughput", "hit_ratio", "memory_gb_s", "memory_utilisation"}) json[key] = nullptr;
  json["config_hash"] = fmt::format("{:016x}", statistics.board.config_hash);
  json["fidelity"] = name_of(statistics.board.fidelity);
  json["seed"] = statistics.seed;
  json["image"] = {{"width", statistics.width}, {"height", statistics.height}};
  json["volume"] = {{"dims", statistics.dims}};
  Json& counters = json["counters"] = Json::object();
  for (const Counter& counter : statistics.counters.list()) {
    counters[counter.name] = {{"value", counter.value}, {"unit", counter.unit}};
  }
  return json;
}

void write_statistics(const FrameStatistics& statistics, const std::filesystem::path& path) {
  std::ofstream stream(path);
  stream << to_json(statistics).dump(2) << '\n';
  stream.close();
  if (!stream) throw InputError(path.string(), "a file that can be written", "an error");
}

}  // namespace gicube::samples
