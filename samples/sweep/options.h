// The command line of gicube-sweep.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "sweep/parameter.h"

namespace gicube::samples::sweep {

struct SweepOptions {
  std::vector<Parameter> parameters;  // the inputs first
  std::vector<Setting> fixed;
  std::vector<Setting> reference;           // a point's reference is itself with these in place; or
  std::filesystem::path reference_picture;  // one picture for all
  std::string cost = "frame_ms";
  std::string error = "picture";
  std::vector<std::string> also;         // further figures
  std::vector<std::string> also_errors;  // further figures' relative differences to the reference's
  std::filesystem::path folder;
  std::string name = "sweep", title;
  int jobs = 0;  // 0 = one a core
  bool chart = false, quiet = false;
};

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<SweepOptions> parse_sweep_options(int argc, const char* const* argv, std::ostream& out);

}  // namespace gicube::samples::sweep
