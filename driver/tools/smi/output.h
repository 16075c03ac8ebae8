// Output of commands: text in columns, numbers with units, JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gicube/v1/management.pb.h"

namespace gicube::smi {

enum class Align { kLeft, kRight };

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // Adds a row; the number of cells must be that of the columns.
  void add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }
  bool empty() const { return rows_.empty(); }

  // Two spaces between columns, no space at the ends of lines; every line ends with a newline.
  std::string text() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

// "12.3 MB" (10^6), "4.56 ms" from picoseconds.
std::string bytes_text(double bytes);
std::string time_text(double picoseconds);

// One field a line, "asic.processors  8", with "(default 4)" behind those that are not the design point's.
std::string configuration_text(const v1::BoardConfig& config);

// Fields by their names in the .proto; 64-bit numbers are strings, as protobuf's JSON has them.
nlohmann::ordered_json to_json(const google::protobuf::Message& message);
// {"board": 0, "simulated_ps": 1, "counters": {"bus.down.bytes": 12}}
nlohmann::ordered_json to_json(const v1::CounterSnapshot& snapshot);

void print(const nlohmann::ordered_json& json);

}  // namespace gicube::smi
