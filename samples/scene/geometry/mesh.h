// A triangle mesh in memory.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gicube/vector.h"

namespace gicube::samples {

struct Mesh {
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // indices of points, counter-clockwise as seen from outside
};

}  // namespace gicube::samples
