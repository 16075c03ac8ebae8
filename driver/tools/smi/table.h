// Text in columns.
#pragma once

#include <string>
#include <vector>

namespace gicube::smi {

enum class Align { kLeft, kRight };

class Table {
 public:
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  // As many cells as columns.
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

}  // namespace gicube::smi
