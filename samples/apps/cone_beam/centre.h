// Finds the position of the axis of rotation on the detector from the projections.
#pragma once

#include "cone_beam/geometry.h"

namespace gicube::samples {

// Returns the detector's offset_u that minimises the difference between opposite measurements of the same lines, in the
// rows nearest to the middle plane. The search covers a quarter of the detector's width on both sides of
// geometry.detector.offset_u. The result is accurate to a tenth of a pixel. Throws BadArgument: views with their own
// poses; an arc that measures no line twice; uniform projections.
double find_offset_u(const ConeGeometry& geometry, const Projections& projections);

}  // namespace gicube::samples
