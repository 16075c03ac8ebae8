#include "studies/results/lit_scenes.h"

#include <string>
#include <utility>

#include "scene/geometry/codebook.h"
#include "scene/program/input_error.h"
#include "scene/scene_file.h"

namespace gicube::samples::results {

SceneData make_lit_scene(SceneName name, int edge, int threads) {
  constexpr double kMaxDensity = 4095;  // of kUint12
  Scene scene = parse_scene(std::string(lit_scene_text(name)), name_of(name) + ".scene", {});
  if (!scene.world) throw InputError(name_of(name), "a scene with a world", "none");
  scene.world->size = edge;
  SceneSetup setup = set_up(scene, threads);
  SceneData data;
  data.volume = std::move(setup.volume);
  data.tags = std::move(setup.tags);
  data.gradients = std::move(setup.gradients);
  if (scene.own_codebook) data.codebook = codebook_of(data.gradients);
  for (const TransferFunctionFile& look : setup.materials) data.looks.push_back(in_values_of({0, kMaxDensity}, look));
  data.shading = setup.shading;
  data.box = setup.box;
  data.optics = std::move(setup.optics);
  data.lights = std::move(setup.lights);
  data.illumination = setup.lighting.settings;
  setup.view.exposure = setup.lighting.exposure;
  data.lit_view = setup.view;
  return data;
}

}  // namespace gicube::samples::results
