// Which way round a volume is, for programs that have volumes from elsewhere.
#pragma once

#include <array>

#include "gicube/export.h"
#include "gicube/vector.h"

namespace gicube::scene {

// The signed permutation that brings axes with these directions (of any length but 0) nearest to x, y and z of their
// world, with a right-handed result: WorldPlacement::stored. {0, 0, 0}: the directions do not span space.
GICUBE_API std::array<int, 3> nearest_axes(const std::array<Vec3, 3>& directions);

}  // namespace gicube::scene
