// A stylised human head with neck: ellipsoids, spheres and a capsule that flow into each other.
#pragma once

#include "scene/geometry/signed_distance.h"

namespace gicube::samples {

// The face looks along -y, the crown along +z; within |x| < 0.65, -0.9 < y < 0.85, -1.1 < z < 0.9. Zero on the surface;
// elsewhere a bound of the distance, whose gradient `away` is at most 1 long.
Distance head_bound(Vec3 p);

}  // namespace gicube::samples
