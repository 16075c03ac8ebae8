// How much light gets through between two points, in double precision: what visibility rays are held against.
#pragma once

#include "field.h"
#include "scene.h"

namespace gicube::reference {

// 0..1. Samples stand in the middles of even steps of at most `step` voxels. `field`: of the scene's volume; both
// points in the volume, in voxels.
double transmittance(const Scene& scene, const Field& field, Vec3 from, Vec3 to, double step);

}  // namespace gicube::reference
