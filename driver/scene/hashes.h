// Hashes of what a scene became.
#pragma once

#include <cstdint>

#include "gicube/scene/scene.h"

namespace gicube::scene {

// SceneSetup::voxel_hash.
std::uint64_t hash_of_voxels(const SceneSetup& setup);

}  // namespace gicube::scene
