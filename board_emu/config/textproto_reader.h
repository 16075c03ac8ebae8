// Strict reading of protobuf text: the board's configuration and its fault plan.
//
// Nothing is guessed and nothing is ignored: every fault is collected, named by its field, and reported with the others.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace gicube::emu {

struct Fault {
  std::string field;  // dotted path, as "asic.processors" or "fault[3].kind"; empty where the text can't be read at all
  std::string expected;
  std::string got;
  int line = 0;  // in the text, from 1; 0 = not known
};

// "line 3: asic.processors: expected 1 to 16, got 99"
std::string to_string(const Fault& fault);
// One fault a line.
std::string to_string(std::span<const Fault> faults);

// Where a text sets each field: dotted path -> line from 1.
using FieldLines = std::map<std::string, int, std::less<>>;

struct TextReading {
  FieldLines lines;
  std::vector<Fault> faults;  // of syntax, names and types
};

// Reads protobuf text into `message`, which then has what the text sets. A faulty value is reported and skipped, so that
// one call finds all of them; only text whose structure is broken ends the search at that line.
TextReading read_text(std::string_view text, google::protobuf::Message& message);

}  // namespace gicube::emu
