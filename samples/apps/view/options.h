// The command line of gicube-view.
#pragma once

#include <iosfwd>
#include <optional>

#include "view/server.h"

namespace gicube::samples::view {

struct ProgramOptions {
  ViewOptions view;
  Listen listen;
  std::optional<bool> open;  // a browser; unset: if there is a desktop
};

// Nothing if help or the version was requested and written to `out`. Throws UsageError with one line.
std::optional<ProgramOptions> parse_options(int argc, const char* const* argv, std::ostream& out);

}  // namespace gicube::samples::view
