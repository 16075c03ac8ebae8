// Light without the steps between clusters, for pictures.
#pragma once

#include <vector>

#include "form_factors/radiosity/radiosity.h"

namespace gicube::samples {

// A solution's incident light is the same all over each cluster that a link ends at, so that pictures show its edges. Here light
// flows between neighbouring elements of one facing, as heat does, as far as the clusters are wide that it came by: sigma is a
// third of their width, weighted by what each brought. What falls on all elements together stays as it is.
std::vector<Power> smoothed(const RadiosityResult& result);

}  // namespace gicube::samples
