// What a transfer function must be before it becomes a quarter of the segmentation LUT.
#pragma once

#include "gicube/transfer_function.h"

namespace gicube {

// Throws BadArgument naming the point: "opacities[3].opacity: expected 0..1, got 1.7". The tag must be 0..3, both lists
// hold a point, values are finite and rise strictly, but two points (not three) may share one value.
void check(const TransferFunction& function, int tag);

}  // namespace gicube
