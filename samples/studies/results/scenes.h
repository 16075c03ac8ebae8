// The scenes that are measured: all procedural, no scan is needed, and any size shows the same thing.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gicube/illumination.h"
#include "gicube/material.h"
#include "gicube/view.h"
#include "gicube/volume.h"
#include "scene/scene.h"

namespace gicube::samples::results {

enum class SceneName { kBuckyball, kHead, kCloud, kRock, kGoldenRing, kMirrorBuckyball, kMirrorHead, kFogBox };
enum class ViewName { kOblique, kAlongX, kAlongY, kAlongZ, kDiagonal };

constexpr SceneName kScenes[] = {SceneName::kBuckyball, SceneName::kHead, SceneName::kCloud, SceneName::kRock};
// Scenes of global illumination; in the last all voxels take light.
constexpr SceneName kLitScenes[] = {SceneName::kGoldenRing, SceneName::kMirrorBuckyball, SceneName::kMirrorHead,
                                    SceneName::kFogBox};
constexpr ViewName kViews[] = {ViewName::kOblique, ViewName::kAlongX, ViewName::kAlongY, ViewName::kAlongZ,
                               ViewName::kDiagonal};

std::string name_of(SceneName scene);
std::string name_of(ViewName view);
// A sentence about what it is there for.
std::string about(SceneName scene);
Colour background_of(SceneName scene);

struct SceneData {
  Volume volume;
  std::vector<std::uint8_t> tags;
  std::vector<float> gradients;
  std::vector<TransferFunction> looks;  // by tag
  Shading shading;
  std::optional<CameraSettings> camera;  // of the oblique view
  VoxelBox box;                          // what is to be seen

  // Of scenes of global illumination.
  std::vector<Material> optics;  // by tag
  std::vector<Light> lights;
  Illumination illumination;
  std::vector<Vec3> codebook;    // empty: the board's own
  std::optional<View> lit_view;  // the scene's camera, exposure and sampling

  VolumeView view() const;
};

// `edge`: voxels to which lengths refer; all dims are equal to it but for boxes cut from a larger whole (cloud and rock
// only, which look the same everywhere).  Throws InputError for a buckyball whose size is out of range.
SceneData make_scene(SceneName scene, const Dims& dims, int edge, int threads);

// The same values visible, but so faint that no ray ever gets opaque.
TransferFunction faint(TransferFunction look);

// The scene's own camera, or one outside that sees all there is; parallel rays for `orthographic`, one pixel a voxel along y.
View make_view(const SceneData& scene, ViewName view, int width, int height, bool orthographic = false);

}  // namespace gicube::samples::results
