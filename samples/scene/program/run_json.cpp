#include "scene/program/run_json.h"

#include "scene/text_file.h"

namespace gicube::samples {

const char* name_of(Fidelity fidelity) {
  switch (fidelity) {
    case Fidelity::kFunctional: return "functional";
    case Fidelity::kApproximate: return "approximate";
    case Fidelity::kCycle: return "cycle";
  }
  return "unknown";
}

nlohmann::ordered_json to_json(const Counters& counters) {
  auto json = nlohmann::ordered_json::object();
  for (const Counter& counter : counters.list())
    json[counter.name] = {{"value", counter.value}, {"unit", counter.unit}};
  return json;
}

void write_json(const nlohmann::ordered_json& json, const std::filesystem::path& path) {
  write_text(path, json.dump(2) + '\n');
}

}  // namespace gicube::samples
