// The tests of gicube-smi validate.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "gicube/board.h"

namespace gicube::smi {

// The board did otherwise than a good board does; the text says what.
class CheckFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Check {
  const char* name;
  // What was seen, in a few words. Throws CheckFailed or gicube::Error.
  std::function<std::string(Board&)> run;
};

// In this order; each leaves the board usable for the next.
std::vector<Check> checks();

}  // namespace gicube::smi
