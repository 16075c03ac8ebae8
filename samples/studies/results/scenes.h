// The scenes that are measured: all procedural, no scan is needed, and any size shows the same thing.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace gicube::samples::results {

// The shipped scenes of global illumination (samples/scenes), by name.
const std::map<std::string, std::string>& lit_scene_texts();

Colour background_of(const std::string& scene);

// Without lights its camera and sampling are the view's own to choose.
struct SceneData : SceneSetup {
  std::vector<Vec3> codebook;  // empty: the board's own
};

// `name`: buckyball, head, cloud, rock, or one of lit_scene_texts(). `edge`: voxels to which lengths refer, those along the
// longest edge of a lit scene's world; all dims are equal to it but for boxes cut from a larger whole (cloud and rock only, which
// look the same everywhere). Throws InputError for another name, or a buckyball whose size is out of range.
SceneData make_scene(const std::string& name, const Dims& dims, int edge, int threads);

// The same values visible, but so faint that no ray ever gets opaque.
TransferFunction faint(TransferFunction transfer_function);

// `view`: oblique, along x, along y, along z or diagonal. The scene's own camera, or one outside that sees all there is; parallel
// rays for `orthographic`, one pixel a voxel along y. Throws InputError for another name.
View make_view(const SceneData& scene, const std::string& view, int width, int height, bool orthographic = false);

}  // namespace gicube::samples::results
