// Rays that lie unevenly against voxels leave ripples, the same in all views along the axis of rotation (docs/guide/cone_beam.md).
#pragma once

#include <vector>

#include "cone_beam/fdk.h"
#include "cone_beam/geometry.h"
#include "cone_beam/reconstruction.h"
#include "gicube/board.h"

namespace gicube::samples {

// Sends all rays again, each with what would make a volume of ones, and divides the values by what that left over what it
// should have: only voxels that every view sees whole, since the others have less for another reason. Adds its rays and deposits
// to the counts. Clears the board's sums.
void normalise(Reconstruction& made, Board& board, const ConeGeometry& geometry, const FdkSettings& settings);

}  // namespace gicube::samples
