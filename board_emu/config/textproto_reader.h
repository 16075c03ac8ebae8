// Strict reading of protobuf text: the board's configuration and its fault plan.
//
// Nothing is guessed and nothing is ignored: everything wrong is collected, named by its field, and reported together.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Descriptor;
class FieldDescriptor;
class Message;
}  // namespace google::protobuf

namespace gicube::emu {

// A longer text is refused unread.
inline constexpr std::size_t kMaxTextBytes = 1 << 20;  // chosen: a configuration is below 1 KB, 10,000 faults 1 MB

struct Diagnostic {
  std::string field;  // dotted path, as "asic.processors" or "fault[3].kind"; empty where the text can't be read at all
  std::string expected;
  std::string got;
  int line = 0;  // in the text, from 1; 0 = not known
};

// "line 3: asic.processors: expected 1 to 16, got 99"
std::string to_string(const Diagnostic& diagnostic);
std::string to_string(std::span<const Diagnostic> diagnostics);

// Where a text sets each field: dotted path -> line from 1.
using FieldLines = std::map<std::string, int, std::less<>>;

struct TextReading {
  FieldLines lines;
  std::vector<Diagnostic> diagnostics;  // of syntax, names and types
  std::size_t left_out = 0;             // faulty values beyond the first hundred
};

// Reads protobuf text into `message`, which then has what the text sets. A faulty value is reported and skipped, so
// that one call finds all of them. Text whose structure is broken ends the search at that line.
TextReading read_text(std::string_view text, google::protobuf::Message& message);

// The names that a schema allows, for error messages: "one of processors, block_voxels, ...".
std::string expected_names(const google::protobuf::Descriptor& type);
// A whole number, one of an enumeration's names (0 is its "unspecified"), or a message.
std::string expected_value(const google::protobuf::FieldDescriptor& field);

// Why the schema refuses a scalar's value: a number beyond its `range` (field_range.proto), or no value of an
// enumeration.
std::optional<Diagnostic> fault_of(const google::protobuf::Message& message,
                                   const google::protobuf::FieldDescriptor& field);

// Sets a number or an enumeration from its text. False, and nothing has changed, if that is no such value.
bool read_value(const std::string& text, const google::protobuf::FieldDescriptor& field,
                google::protobuf::Message& message);

}  // namespace gicube::emu
