// What gicube-path is asked for.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>

#include "path/bidirectional.h"
#include "scene/program/board_options.h"
#include "scene/program/progress.h"
#include "transport/program/light_input.h"

namespace gicube::samples {

struct PathOptions {
  LightInput light;
  BidirectionalSettings settings;
  int passes = 16;
  BoardOptions board;
};

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<PathOptions> parse_path_options(int argc, const char* const* argv, std::ostream& out);

// Throws UsageError, InputError, FileError, and what Board throws.
void run(const PathOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
