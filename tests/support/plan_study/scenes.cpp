#include "scenes.h"

#include "gicube/scene/scene.h"

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
  study.scene.volume.as_stored = true;  // cameras of the study are placed in these axes
  study.scene.transfer_function = samples::find_preset(preset);
  return study;
}

StudyScene world(const std::string& name, const std::filesystem::path& file, int size) {
  StudyScene study{name, "lit by illuminate()", samples::read_scene(file)};
  study.scene.world->size = size;
  return study;
}

using Scenes = std::vector<StudyScene>;

void look(StudyScene& study, Vec3 eye, Vec3 at, double fov_degrees) {
  study.scene.camera.eye = eye;
  study.scene.camera.look_at = at;
  study.scene.camera.fov_degrees = fov_degrees;
}

Scenes first_batch(const std::filesystem::path& data, const std::filesystem::path& sources) {
  Scenes scenes{scan("mouse", data / "mouse_head_microct/C57BL6_J_.nii.gz", "micro-ct-bone"),
                scan("T1", data / "stroke_brain_mri/T1.nii.gz", "mri-brain"),
                scan("FLAIR, not shaded", data / "stroke_brain_mri/FLAIR.nii.gz", "mri-brain"),
                scan("head, bone", data / "visible_human_female_head_ct", "ct-bone"),
                scan("head, skin", data / "visible_human_female_head_ct", "ct-skin"),
                buckyball("ball, cut, from near", 128),
                buckyball("ball, far away", 256),
                world("subsurface", sources / "samples/scenes/subsurface.scene", 64)};
  scenes[2].scene.view.shade = false;
  scenes[3].max_volume_voxels = scenes[4].max_volume_voxels = 512;  // its slices are 512 x 512
  look(scenes[5], {20, -90, 110}, {64, 64, 64}, 35);
  scenes[5].scene.view.cut_planes = {{{0, 1, 0.2}, 60}};
  look(scenes[6], {-700, -2400, 1100}, {128, 128, 128}, 22);
  return scenes;
}

Scenes second_batch(const std::filesystem::path& data, const std::filesystem::path& sources) {
  Scenes scenes{scan("T2", data / "stroke_brain_mri/T2.nii.gz", "mri-brain"),
                scan("head from behind", data / "visible_human_female_head_ct", "ct-skin"),
                scan("mouse, ramp", data / "mouse_head_microct/C57BL6_J_.nii.gz", "ramp"),
                scan("engine, cut", data / "engine_ct/engine.nii.gz", "ct-engine"),
                buckyball("small ball, magnified", 64),
                world("fog box", sources / "samples/scenes/fog_box.scene", 64),
                world("golden ring", sources / "samples/scenes/golden_ring.scene", 64)};
  scenes[1].max_volume_voxels = 512;
  look(scenes[1], {600, 900, 400}, {256, 256, 117}, 40);
  scenes[1].scene.camera.up = Vec3{0, 0, 1};
  look(scenes[2], {85, 60, 500}, {85, 85, 73}, 30);
  scenes[2].scene.camera.up = Vec3{0, 1, 0};
  look(scenes[3], {300, 340, 260}, {128, 128, 64}, 38);
  scenes[3].scene.camera.up = Vec3{0, 0, 1};
  scenes[3].scene.view.cut_planes = {{{-1, 0, 0}, -150}};
  look(scenes[4], {10, -70, 60}, {32, 32, 32}, 24);
  return scenes;
}

}  // namespace

bool StudyScene::available() const {
  return scene.world || !scene.volume.builtin.empty() || std::filesystem::exists(scene.volume.file);
}

std::vector<StudyScene> study_scenes(const std::filesystem::path& data, const std::filesystem::path& sources) {
  Scenes all{buckyball("buckyball", 256), scan("engine", data / "engine_ct/engine.nii.gz", "ct-engine")};
  int batch = 0;
  for (Scenes scenes : {first_batch(data, sources), second_batch(data, sources)}) {
    ++batch;
    for (StudyScene& study : scenes) {
      study.batch = batch;
      all.push_back(std::move(study));
    }
  }
  return all;
}

std::vector<LitScene> lit_scenes(const std::filesystem::path& data, const std::filesystem::path& sources) {
  const auto of = [&](const char* name, const char* file, double max_error, int batch) {
    LitScene scene{world(name, sources / "samples/scenes" / file, 48), max_error};
    scene.study.scene.lighting.colour_passes = false;  // one pass: all of the picture is by one light
    scene.study.batch = batch;
    return scene;
  };
  const auto lit = [](StudyScene study, double max_error) {
    study.scene.lighting.on = true;
    study.scene.lighting.settings.rays_per_face_voxel = 16;
    study.look += ", lit";
    study.batch = 1;
    return LitScene{std::move(study), max_error};
  };
  return {of("golden ring", "golden_ring.scene", 0.1, 0),
          of("fog box", "fog_box.scene", 0.1, 0),
          of("subsurface", "subsurface.scene", 0.15, 0),
          of("mirror and ball", "mirror_buckyball.scene", 0.1, 1),
          of("mirror and ball, area light", "mirror_buckyball_area.scene", 0.1, 1),
          of("mirror and head", "mirror_head.scene", 0.1, 1),
          of("glass", "glass.scene", 0.1, 1),
          of("mirror and head, 4%", "mirror_head.scene", 0.04, 1),
          of("glass, 20%", "glass.scene", 0.2, 1),
          lit(buckyball("ball", 64), 0.1),
          lit(scan("T1", data / "stroke_brain_mri/T1.nii.gz", "mri-brain"), 0.1)};
}

}  // namespace gicube::plan_study
