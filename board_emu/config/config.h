// The board's configuration: protobuf text and overrides in, a complete and checked BoardConfig out.
//
// Nothing is guessed and nothing is ignored: everything wrong is collected, named by its field, and reported together.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/v1/board_config.pb.h"
#include "textproto_reader.h"

namespace gicube::emu {

struct ParsedConfig : TextReading {  // ranges are check()'s
  v1::BoardConfig config;            // only what the text sets
};

// Reads protobuf text, as read_text(): one call finds all faulty values.
ParsedConfig parse_config(std::string_view text);

// Sets one field from "asic.processors=8". If that is wrong the configuration stays as it was.
std::vector<Diagnostic> apply_override(v1::BoardConfig& config, std::string_view assignment);

// The same configuration with every field present, defaults included.
v1::BoardConfig resolve(const v1::BoardConfig& config);

// Every value out of its range and every contradiction; fields that are not set count with their defaults.
std::vector<Diagnostic> check(const v1::BoardConfig& config, const FieldLines& lines = {});

// 64-bit FNV-1a of the resolved configuration's text, `threads` left out: equal hashes mean equal results.
std::uint64_t config_hash(const v1::BoardConfig& config);
std::string config_hash_text(const v1::BoardConfig& config);

// Every field that results or times depend on, a line each: name, value, what a number may be, whether the level does not model it, its
// default if it has another, and where the default comes from.
std::string explained(const v1::BoardConfig& config);

// The resolved configuration as protobuf text, which parse_config() reads back.
std::string config_text(const v1::BoardConfig& config);

}  // namespace gicube::emu
