// Resamples views of tilted, turned or shifted detectors to detectors that face the axis of rotation squarely.
#pragma once

#include <array>

#include "cone_beam/geometry.h"

namespace gicube::samples {

struct FacingViews {
  ConeGeometry geometry;  // circular
  Projections projections;
};

// Resamples by Catmull and Rom's cubics. Pixels outside the detector repeat its edge. Views of one angle are averaged.
// Throws BadArgument with the first source that is more than half a pixel, scaled to the axis, off the mean circle
// about z [C: it moves no ray by more than a fraction of that inside the volume].
FacingViews facing(const ConeGeometry& geometry, const Projections& projections);

// Weights of four pixels for a value between the second and the third, by Catmull and Rom's cubic. The cubic through
// all four loses more of the highest frequencies. A Fourier transform would be exact for band-limited rows, but edges
// would ring.
std::array<double, 4> cubic(double t);

}  // namespace gicube::samples
