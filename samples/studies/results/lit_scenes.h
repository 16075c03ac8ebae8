// The shipped scenes of global illumination (samples/scenes), voxelised at the size at which they are measured.
#pragma once

#include <string_view>

#include "studies/results/scenes.h"

namespace gicube::samples::results {

// The scene's file; empty for scenes without one.
std::string_view lit_scene_text(SceneName scene);

// `edge`: voxels along the longest edge of its world. Throws InputError for a scene without a file.
SceneData make_lit_scene(SceneName scene, int edge, int threads);

}  // namespace gicube::samples::results
