// The parts that the programs' statistics files share.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "gicube/board.h"

namespace gicube::samples {

const char* name_of(Fidelity fidelity);

// An object: name to { value, unit }.
nlohmann::ordered_json to_json(const Counters& counters);

// Throws InputError if the file can't be written.
void write_json(const nlohmann::ordered_json& json, const std::filesystem::path& path);

}  // namespace gicube::samples
