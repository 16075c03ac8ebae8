// Views whose detectors are tilted, turned or shifted, as a detector would see them that faces the axis of rotation
// squarely.
#pragma once

#include <array>

#include "cone_beam/geometry.h"

namespace gicube::samples {

struct FacingViews {
  ConeGeometry geometry;  // circular
  Projections projections;
};

// Resamples by Catmull and Rom's cubics: a ray is the same wherever a detector catches it. Pixels that a detector has
// not seen repeat its edge. Views of one angle are averaged. Throws BadArgument that names the first source that is
// more than half a pixel, as seen at the axis, off the mean circle about z [C: it moves no ray by more than a fraction
// of that inside of the volume].
FacingViews facing(const ConeGeometry& geometry, const Projections& projections);

// Weights of four pixels for a value between the second and the third, by Catmull and Rom's cubic. The cubic through
// all four loses more of the highest frequencies, and a transform, exact for rows of limited band, would make those of
// edges ring.
std::array<double, 4> cubic(double t);

}  // namespace gicube::samples
