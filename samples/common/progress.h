// One line on a terminal that says how far a long call is; nothing where there is no terminal.
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "gicube/board.h"

namespace gicube::samples {

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
};

}  // namespace gicube::samples
