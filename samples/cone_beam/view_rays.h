// Rays through the middles of one view's pixels.
#pragma once

#include <vector>

#include "cone_beam/geometry.h"
#include "gicube/ray.h"

namespace gicube::samples {

// The piece of a ray that runs through the volume, in voxels, clipped to the box of voxel centres; no length: none.
HostRay clipped_ray(const Grid& grid, Vec3 source, Vec3 pixel);

// fine x fine a pixel, rows first, each of fine x columns: the pieces within the volume (clipped_ray()), of no length where
// a ray misses it.
std::vector<HostRay> view_rays(const ConeGeometry& geometry, double angle, int fine = 1);

// In the unit of grid.spacing; 0 of a ray of no length.
double length_in_space(const Grid& grid, const HostRay& ray);

}  // namespace gicube::samples
