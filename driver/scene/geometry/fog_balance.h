// Fog beside solids. A voxel has one tag, and voxels that show a solid show no fog, although part of their cubes, and
// of those around them, is outside the solid. The missing fog is added to the nearest voxels of fog, so that the sum
// over a few voxels is that of the open space: the fog along a ray is correct to second order in the voxel's size.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gicube/scene/voxeliser.h"

namespace gicube::scene {

constexpr std::uint16_t kNoFogDue = 0xFFFF;

// `due`: for each voxel, the fog's density that its cube should have, without the part within solids; kNoFogDue far
// from solids. Changes only voxels whose tags are in `fogs`: their densities are scaled from kFogDensity to
// kFogBesideSolids, to which their extinction is proportional, and then increased. Does nothing if no solid is in fog.
void balance_fog(VoxelWorld& world, const std::array<bool, 4>& fogs, std::span<const std::uint16_t> due);

}  // namespace gicube::scene
