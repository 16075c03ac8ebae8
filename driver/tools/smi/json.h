// Messages of the management plane as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "gicube/v1/management.pb.h"

namespace gicube::smi {

// Fields by their names in the .proto; 64-bit numbers are strings, as protobuf's JSON has them.
nlohmann::ordered_json to_json(const google::protobuf::Message& message);
// {"board": 0, "simulated_ps": 1, "counters": {"bus.down.bytes": 12}}
nlohmann::ordered_json to_json(const v1::CounterSnapshot& snapshot);

void print(const nlohmann::ordered_json& json);

}  // namespace gicube::smi
