// gicube-compose: its options and its work.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "compose/picture.h"
#include "scene/program/board_options.h"
#include "scene/program/progress.h"

namespace gicube::samples {

struct ComposeOptions {
  std::filesystem::path composition;
  bool allow_outside = false;
  std::filesystem::path picture;           // PNG or EXR; empty: none
  std::optional<std::array<int, 2>> size;  // replaces the composition's
  std::optional<int> samples_per_axis;
  std::optional<double> step, overlap_step;
  int boards = 1;
  BoardOptions board;
};

// Empty after printing help or the version to `out`. Throws UsageError with one line.
std::optional<ComposeOptions> parse_compose_options(int argc, const char* const* argv, std::ostream& out);

// Throws UsageError, InputError, FileError, and what Board throws.
void run(const ComposeOptions& options, ProgressLine& progress);

// Simulated time of one picture. Boards work in parallel, each on its volumes in sequence. `again`: of a further
// picture; a board with a single volume need not load it again.
Picoseconds time_of(const std::vector<MediumCost>& costs, bool again);

}  // namespace gicube::samples
