// The board's configuration: reads protobuf text and overrides, returns a complete and checked BoardConfig.
//
// No value is guessed and no field is ignored. All errors are collected and reported together, with their field names.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/v1/board_config.pb.h"
#include "textproto_reader.h"

namespace gicube::emu {

struct ParsedConfig : TextReading {  // does not check ranges; check() does
  v1::BoardConfig config;            // only the fields set by the text
};

// Reads protobuf text (see read_text()) and reports all invalid values at once.
ParsedConfig parse_config(std::string_view text);

// Sets one field from text such as "asic.processors=8". On an error the configuration does not change.
std::vector<Diagnostic> apply_override(v1::BoardConfig& config, std::string_view assignment);

// Level 2 of release 0.2. For one release a board uses `cycle` instead, and logs this text.
inline bool wants_approximate(const v1::BoardConfig& config) { return config.fidelity() == 2; }
inline constexpr std::string_view kApproximateIsCycle =
    "fidelity: expected functional or cycle, got approximate: cycle is used. Later releases refuse the name";

// Returns the configuration with all fields set, including defaults. Its level is never `approximate`.
v1::BoardConfig resolve(const v1::BoardConfig& config);

// Reports all values out of range and all contradictions. Fields that are not set count with their defaults.
std::vector<Diagnostic> check(const v1::BoardConfig& config, const FieldLines& lines = {});

// 64-bit FNV-1a hash of the resolved configuration's text without `threads`, `pace` and usual prices of energy. Equal
// hashes mean equal results.
std::uint64_t config_hash(const v1::BoardConfig& config);
std::string config_hash_text(const v1::BoardConfig& config);

// All fields that affect results or times, one per line: name, value, range of a number, a note if the level does not
// model it, the default if the value differs, and the source of the default.
std::string explained(const v1::BoardConfig& config);

// The resolved configuration as protobuf text that parse_config() can read.
std::string config_text(const v1::BoardConfig& config);

}  // namespace gicube::emu
