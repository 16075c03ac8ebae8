// Where the axis of rotation is seen, found from the projections themselves.
#pragma once

#include "cone_beam/geometry.h"

namespace gicube::samples {

// The detector's offset_u by which lines that were measured from both sides, in the rows nearest to the middle plane,
// differ least. It is looked for within a quarter of the detector's width of geometry.detector.offset_u, and is good to
// a tenth of a pixel. Throws BadArgument: views of their own poses; an arc in which no line is measured twice;
// projections that are the same everywhere.
double find_offset_u(const ConeGeometry& geometry, const Projections& projections);

}  // namespace gicube::samples
