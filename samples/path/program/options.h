// What gicube-path is asked for.
#pragma once

#include <iosfwd>
#include <optional>

#include "path/bidirectional.h"
#include "scene/program/progress.h"
#include "transport/program/light_options.h"

namespace gicube::samples {

using PathOptions = LightOptions<BidirectionalSettings>;

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<PathOptions> parse_path_options(int argc, const char* const* argv, std::ostream& out);

// Throws UsageError, InputError, FileError, and what Board throws.
void run(const PathOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
