// Rays of the host application on their way to the board and back.
#pragma once

#include <cstddef>

#include "gicube/ray.h"
#include "gicube/vector.h"
#include "gicube/wire/ray.h"

namespace gicube {

// Throws BadArgument naming ray and field: "rays[7].position.x: expected 0..31, got 32.5".
void check(const HostRay& ray, std::size_t index, Dims dims);

// Position rounded to 1/16384 voxel; direction brought to unit length in voxel space, then rounded to 1/16384.
// For a ray that passed check().
wire::Ray to_wire(const HostRay& ray);

// The direction as the board holds it: of unit length to its rounding.
TracedRay from_wire(const wire::Ray& ray);

}  // namespace gicube
