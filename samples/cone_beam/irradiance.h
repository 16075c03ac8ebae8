// Backprojection into the words that the paper has for lighting [P §4.2]: 11 bits, without a sign.
#pragma once

#include <functional>
#include <vector>

#include "cone_beam/fdk.h"
#include "cone_beam/geometry.h"
#include "cone_beam/reconstruction.h"
#include "gicube/board.h"

namespace gicube::samples {

// What the rays of a view leave in a unit of volume (filtered_view()).
using FilteredView = std::function<std::vector<double>(std::size_t view)>;

// Some views at a time: their positive values in one pass, their negative ones in a second one, the words' unit chosen for each
// pass by the greatest that a voxel can get of it. The words are read after each pass; the host adds up.
Reconstruction backproject_into_irradiance(Board& board, const ConeGeometry& geometry, const FdkSettings& settings,
                                           const FilteredView& filtered, const Progress& progress);

}  // namespace gicube::samples
