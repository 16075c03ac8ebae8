// How much opacities differ where densities do.
#pragma once

#include <span>

#include "gicube/transfer_function.h"
#include "gicube/volume.h"

namespace gicube {

// The most by which opacities of two densities in low..high can differ that are at most `distance` apart; densities of
// 0..4095, which stand for `range`. Where tags meet, a coarse voxel may have taken either, so any two functions count.
// Without one it is 0.
double largest_opacity_change(std::span<const TransferFunction> functions, ValueRange range, int low, int high,
                              int distance);

}  // namespace gicube
