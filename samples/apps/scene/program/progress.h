// One line on a terminal that says how far a long call is and how much time is left; silent without a terminal that
// can erase lines.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <string>

#include "gicube/board.h"

namespace gicube::samples {

// ", 12 s left", ", 3 min 20 s left", ", 2 h 5 min left" as the part done so far promises; empty in the first two
// seconds [C] and at the end, when nothing can be said yet and nothing is left.
std::string time_left(double elapsed_seconds, std::uint32_t done, std::uint32_t all);

// Whether a stream is a terminal that knows the escape code for it: TERM is set, and not to "dumb".
bool can_erase_lines(std::FILE* stream);

// On standard error, in place of a ProgressLine that is there: "PROGRAM: warning: TEXT".
void print_warning(const char* program, const std::string& text);

class ProgressLine {
 public:
  // `shown`: false keeps it silent, whatever `stream` is.
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
