#include "scene/program/run_json.h"

#include <fstream>

#include "scene/program/input_error.h"

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
  std::ofstream stream(path);
  stream << json.dump(2) << '\n';
  stream.close();
  if (!stream) throw InputError(path.string(), "a file that can be written", "an error");
}

}  // namespace gicube::samples
