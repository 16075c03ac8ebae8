// Strict reading of protobuf text: the board's configuration and its fault plan.
//
// No value is guessed and no field is ignored. All errors are collected and reported together, with their field names.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class FieldDescriptor;
class Message;
}  // namespace google::protobuf

namespace gicube::emu {

// A longer text is refused without reading it.
inline constexpr std::size_t kMaxTextBytes = 1 << 20;  // chosen: a configuration is below 1 KB, 10,000 faults 1 MB

struct Diagnostic {
  std::string field;  // dotted path, such as "asic.processors" or "fault[3].kind"; empty for an error of syntax
  std::string expected;
  std::string got;
  int line = 0;  // line of the text, from 1; 0 = unknown
};

// For example "line 3: asic.processors: expected 1 to 16, got 99".
std::string to_string(const Diagnostic& diagnostic);
std::string to_string(std::span<const Diagnostic> diagnostics);

// The line, from 1, in which a text sets each field, by the field's dotted path.
using FieldLines = std::map<std::string, int, std::less<>>;

struct TextReading {
  FieldLines lines;
  std::vector<Diagnostic> diagnostics;  // errors of syntax, names and types
  std::size_t left_out = 0;             // number of errors beyond the first hundred
};

// Reads protobuf text into `message`. Invalid values are reported and skipped, so that one call finds all of them. An
// error of syntax ends the reading.
TextReading read_text(std::string_view text, google::protobuf::Message& message);

// The valid values of a field, for error messages: a whole number, one of an enumeration's names, or a message.
std::string expected_value(const google::protobuf::FieldDescriptor& field);

// Returns the error of a scalar's value: a number outside its `range` (field_range.proto), or an enumeration's
// unspecified value.
std::optional<Diagnostic> fault_of(const google::protobuf::Message& message,
                                   const google::protobuf::FieldDescriptor& field);

}  // namespace gicube::emu
