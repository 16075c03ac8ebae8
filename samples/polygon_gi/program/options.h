// gicube-polygon-gi: what it is asked for, and its work.
#pragma once

#include <optional>
#include <ostream>

#include "polygon_gi/polygon_gi.h"
#include "scene/program/progress.h"
#include "transport/program/light_options.h"

namespace gicube::samples {

// `passes`: rays of the picture for each pixel.
struct PolygonGiOptions : LightOptions<PolygonGiSettings> {
  double edge = 2;  // voxels: the longest of a triangle
};

// Nothing if help or the version was asked for and went to `out`. Throws UsageError with one line.
std::optional<PolygonGiOptions> parse_polygon_gi_options(int argc, const char* const* argv, std::ostream& out);

// Throws UsageError, InputError, FileError, and what Board throws.
void run(const PolygonGiOptions& options, ProgressLine& progress);

}  // namespace gicube::samples
