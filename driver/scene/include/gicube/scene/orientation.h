// The orientation of a volume, for programs with volumes from other sources.
#pragma once

#include <array>

#include "gicube/export.h"
#include "gicube/vector.h"

namespace gicube::scene {

// The signed permutation that brings axes with these directions, whose lengths must not be 0, nearest to x, y and z of
// their world, with a right-handed result, as in WorldPlacement::stored. {0, 0, 0}: the directions do not span space.
GICUBE_API std::array<int, 3> nearest_axes(const std::array<Vec3, 3>& directions);

}  // namespace gicube::scene
