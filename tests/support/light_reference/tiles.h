// How sure a reference picture is.
#pragma once

#include "reference/paths/path_tracer.h"

namespace gicube::light_reference {

// Of the means of tiles of `edge` x `edge` pixels (what is left at the right and below counts as smaller tiles): the
// root of the sum of their squared standard errors, over the root of the sum of their squares, all channels together.
// Pixels are independent.
double relative_error(const reference::paths::RadiancePicture& picture, int edge);

}  // namespace gicube::light_reference
