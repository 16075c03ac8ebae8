// Fog beside solids. A voxel has one tag, and those that show a solid show no fog, although part of their cubes, and
// of those around, is open. The fog that is missing there is added to the voxels of fog nearest to it, so
// that the sum over a few voxels is that of the open space: to second order in the voxel light passes through as much
// fog as there is.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "gicube/scene/voxeliser.h"

namespace gicube::scene {

constexpr std::uint16_t kNoFogDue = 0xFFFF;

// `due`: by voxel, the density that its cube's fog should have, with that of the part within solids left out;
// kNoFogDue far from solids. Changes the densities of voxels with one of the tags in `fogs` alone: from kFogDensity
// to kFogBesideSolids, in proportion to which their extinction is, and up. Nothing, if no solid shows in a fog.
void balance_fog(VoxelWorld& world, const std::array<bool, 4>& fogs, std::span<const std::uint16_t> due);

}  // namespace gicube::scene
