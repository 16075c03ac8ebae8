#include "plan_study/scenes.h"

#include "common/scene_file.h"

namespace gicube::plan_study {
namespace {

StudyScene buckyball(const std::string& name, int size) {
  StudyScene study{name, "its own", {}};
  study.scene.volume.builtin = "buckyball";
  study.scene.volume.size = size;
  return study;
}

StudyScene scan(const std::string& name, const std::filesystem::path& file, const std::string& preset) {
  StudyScene study{name, preset, {}};
  study.scene.volume.file = file;
  study.scene.transfer_function = samples::find_preset(preset);
  return study;
}

StudyScene world(const std::string& name, const std::filesystem::path& file, int size) {
  StudyScene study{name, "lit by illuminate()", samples::read_scene(file)};
  study.scene.world->size = size;
  return study;
}

}  // namespace

bool StudyScene::available() const {
  return scene.world || !scene.volume.builtin.empty() || std::filesystem::exists(scene.volume.file);
}

std::vector<StudyScene> study_scenes(const std::filesystem::path& data, const std::filesystem::path& sources) {
  std::vector<StudyScene> scenes{buckyball("buckyball", 256),
                                 scan("engine", data / "engine_ct/engine.nii.gz", "ct-engine")};
  for (StudyScene& study : scenes) study.held_out = false;

  scenes.push_back(scan("mouse", data / "mouse_head_microct/C57BL6_J_.nii.gz", "micro-ct-bone"));
  scenes.push_back(scan("T1", data / "stroke_brain_mri/T1.nii.gz", "mri-brain"));
  scenes.push_back(scan("FLAIR, not shaded", data / "stroke_brain_mri/FLAIR.nii.gz", "mri-brain"));
  scenes.back().scene.view.shade = false;
  for (const char* preset : {"ct-bone", "ct-skin"}) {
    const std::string part = std::string(preset).substr(3);
    scenes.push_back(scan("head, " + part, data / "visible_human_female_head_ct", preset));
    scenes.back().max_volume_voxels = 512;  // its slices are 512 x 512
  }
  scenes.push_back(buckyball("ball, cut, from near", 128));
  scenes.back().scene.camera.eye = Vec3{20, -90, 110};
  scenes.back().scene.camera.look_at = Vec3{64, 64, 64};
  scenes.back().scene.camera.fov_degrees = 35;
  scenes.back().scene.view.cut_planes = {{{0, 1, 0.2}, 60}};
  scenes.push_back(buckyball("ball, far away", 256));
  scenes.back().scene.camera.eye = Vec3{-700, -2400, 1100};
  scenes.back().scene.camera.look_at = Vec3{128, 128, 128};
  scenes.back().scene.camera.fov_degrees = 22;
  scenes.push_back(world("subsurface", sources / "samples/scenes/subsurface.scene", 64));
  return scenes;
}

}  // namespace gicube::plan_study
