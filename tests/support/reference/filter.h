// From rays to pixels.
#pragma once

#include "gicube/view.h"
#include "scene.h"

namespace gicube::reference {

// `rays` has per_axis^2 rays a pixel, each in the middle of its part of the pixel.
// Box: the mean of a pixel's own rays. Tent: the mean of all rays less than a pixel away in x and in y from the pixel's
// middle, weighted by (1 - |dx|)(1 - |dy|), over the sum of the weights of those rays that are in the image.
Picture filter(const Picture& rays, int per_axis, PixelFilter filter);

}  // namespace gicube::reference
