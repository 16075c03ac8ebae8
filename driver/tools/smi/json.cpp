#include "json.h"

#include <fmt/format.h>
#include <google/protobuf/util/json_util.h>

#include <stdexcept>

namespace gicube::smi {

nlohmann::ordered_json to_json(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.preserve_proto_field_names = true;
  options.always_print_primitive_fields = true;
  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(message, &text, options);
  if (!status.ok()) throw std::runtime_error("the answer can't be written as JSON: " + std::string(status.message()));
  return nlohmann::ordered_json::parse(text);
}

nlohmann::ordered_json to_json(const v1::CounterSnapshot& snapshot) {
  nlohmann::ordered_json counters = nlohmann::ordered_json::object();
  for (const v1::Counter& counter : snapshot.counters()) counters[counter.name()] = counter.value();
  return {{"board", snapshot.board()}, {"simulated_ps", snapshot.simulated_ps()}, {"counters", std::move(counters)}};
}

void print(const nlohmann::ordered_json& json) { fmt::print("{}\n", json.dump(2)); }

}  // namespace gicube::smi
