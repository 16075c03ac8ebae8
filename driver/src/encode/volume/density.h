// A volume's values as the board's 12-bit densities.
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/volume.h"

namespace gicube {

// Of one value, as below.
std::uint16_t to_density(double value, ValueRange range);

// round(4095 (v - low) / (high - low)), clamped to 0..4095; one a voxel, x fastest.
// For a view that passed check_volume().
std::vector<std::uint16_t> to_densities(const VolumeView& view, ValueRange range);

}  // namespace gicube
