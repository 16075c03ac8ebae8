#include "scenes.h"

#include "reference/field.h"

namespace gicube::accuracy {

namespace {

StudyScene scan(const std::string& name, const std::filesystem::path& file, const std::string& preset) {
  StudyScene study{name, preset, {}, 0};
  study.scene.volume.file = file;
  study.scene.transfer_function = samples::find_preset(preset);
  return study;
}

}  // namespace

bool StudyScene::available() const {
  return !scene.volume.builtin.empty() || std::filesystem::exists(scene.volume.file);
}

std::vector<StudyScene> study_scenes(const std::filesystem::path& data, int buckyball_size) {
  StudyScene buckyball{"buckyball", "its own", {}, 0};
  buckyball.scene.volume.builtin = "buckyball";
  buckyball.scene.volume.size = buckyball_size;
  std::vector<StudyScene> scenes{buckyball,
                                 scan("engine", data / "engine_ct/engine.nii.gz", "ct-engine"),
                                 scan("mouse", data / "mouse_head_microct/C57BL6_J_.nii.gz", "micro-ct-bone"),
                                 scan("brain", data / "stroke_brain_mri/T1.nii.gz", "mri-brain"),
                                 scan("head-bone", data / "visible_human_female_head_ct", "ct-bone"),
                                 scan("head-skin", data / "visible_human_female_head_ct", "ct-skin")};
  for (StudyScene& study : scenes) {
    if (study.name.starts_with("head")) study.max_volume_voxels = 512;  // its slices are 512 x 512
  }
  return scenes;
}

reference::Scene to_reference(const samples::SceneSetup& setup) {
  reference::Scene scene;
  scene.volume = setup.volume_view();
  const ValueRange range = reference::value_range(scene.volume);
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    scene.functions[tag] = samples::in_values_of(range, setup.materials[tag]);
  }
  scene.shading = setup.shading;
  scene.view = setup.view;
  return scene;
}

}  // namespace gicube::accuracy
