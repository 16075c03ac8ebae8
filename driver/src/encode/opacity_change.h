// The difference of opacities for a difference of densities.
#pragma once

#include <span>

#include "gicube/transfer_function.h"
#include "gicube/volume.h"

namespace gicube {

// The largest difference of the opacities of two densities in low..high that are at most `distance` apart. Densities
// 0..4095 stand for `range`. Any two functions are compared, because a coarse voxel may have either of several tags. 0
// without functions.
double largest_opacity_change(std::span<const TransferFunction> functions, ValueRange range, int low, int high,
                              int distance);

}  // namespace gicube
