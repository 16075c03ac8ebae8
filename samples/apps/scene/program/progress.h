// A line on a terminal with the progress of a long call and the remaining time; silent unless the terminal can erase
// lines.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

#include "gicube/board.h"

namespace gicube::samples {

// The remaining time, estimated from the completed part: ", 12 s left", ", 3 min 20 s left", ", 2 h 5 min left"; empty
// in the first two seconds [C] and at the end.
std::string time_left(double elapsed_seconds, std::uint32_t done, std::uint32_t all);

// Whether a stream is a terminal that supports erasing lines: TERM is set, and not to "dumb".
bool can_erase_lines(std::FILE* stream);

// Prints "PROGRAM: warning: TEXT" on standard error, replacing a ProgressLine.
void print_warning(const char* program, const std::string& text);

class ProgressLine {
 public:
  // `shown`: false makes it silent on every stream.
  explicit ProgressLine(bool shown, std::FILE* stream = stderr);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(const std::string& what);       // a step without parts
  Progress parts(const std::string& what);  // for the driver; this object must outlive the call
  void clear();

 private:
  std::FILE* stream_;
  bool shown_;
  bool dirty_ = false;
  int percent_ = -1;
  std::chrono::steady_clock::time_point shown_at_{};
};

}  // namespace gicube::samples
