#include "datapath/ray_step.h"

#include <cmath>

namespace gicube::emu {

std::uint32_t physical_length(const std::array<std::int16_t, 3>& direction,
                              const std::array<std::uint32_t, 3>& spacing) {
  if (spacing[0] == spacing[1] && spacing[1] == spacing[2]) return spacing[0];
  double voxels = 0, physical = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double d = direction[axis], scaled = d * spacing[axis];
    voxels += d * d;
    physical += scaled * scaled;
  }
  return static_cast<std::uint32_t>(std::lround(std::sqrt(physical / voxels)));
}

}  // namespace gicube::emu
