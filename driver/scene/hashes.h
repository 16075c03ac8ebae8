// Hash of a scene's voxels.
#pragma once

#include <cstdint>

#include "gicube/scene/scene.h"

namespace gicube::scene {

// The value of SceneSetup::voxel_hash.
std::uint64_t hash_of_voxels(const SceneSetup& setup);

}  // namespace gicube::scene
