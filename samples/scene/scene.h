// What a sample draws: a scene as its user asked for it, and the same scene ready for the board.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"
#include "scene/formats/volume_file.h"
#include "scene/graph/engine.h"
#include "scene/graph/light.h"
#include "scene/graph/material.h"
#include "scene/graph/world.h"
#include "scene/transfer_function_file.h"
#include "scene/visible_box.h"

namespace gicube::samples {

// Positions in the scene's units. What is not set is chosen to show the whole volume (fit_camera).
struct CameraSettings {
  std::string name;
  std::optional<Vec3> eye, look_at, up;
  std::optional<double> fov_degrees;          // vertical
  std::optional<double> orthographic_height;  // in (smallest) voxel edges; set = orthographic
};

// One function for all tags, or one a tag.
using Materials = std::vector<TransferFunctionFile>;

// What a built-in scene brings along; a user's wishes come first.
struct Appearance {
  Materials materials;  // by tag
  Phong phong;
  std::optional<Vec3> light;
  CameraSettings camera;
  std::optional<Colour> background;
};

// Lengths and positions are in the scene's units: world units if there is a world, else voxels of the volume.
struct Scene {
  VolumeSource volume;         // or
  std::optional<World> world;  // in place of a volume
  std::vector<SceneMaterial> materials;
  std::optional<TransferFunctionFile> transfer_function;  // for every tag, in place of the materials'
  std::optional<Phong> phong;
  std::optional<Vec3> light;  // towards the light of pictures without illumination; else the first directional of:
  std::vector<SceneLight> lights;
  Lighting lighting;
  CameraSettings camera;
  std::vector<CameraSettings> more_cameras;
  std::vector<Engine> engines;
  std::optional<Colour> background;
  bool own_codebook = true;  // worlds: normals are coded by a codebook of their own (geometry/codebook.h)
  View view;  // image and sampling, cut planes in the scene's units; the camera's fields are filled by set_up()
};

// Makes the camera of this name the scene's own. Throws InputError with the names of those that are there.
void choose_camera(Scene& scene, const std::string& name);

// Owns what a VolumeView points to. Everything in it is in voxels.
struct SceneSetup : VoxelWorld {
  WorldGrid grid;       // of the scene's units; the identity without a world
  VoxelBox box;         // what the camera is to see, unless it is told
  Appearance built_in;  // what a built-in volume, or the preset of a file, brings along

  Materials materials;
  std::vector<Material> optics;            // by tag
  std::vector<Colour> scattering_colours;  // by tag
  std::vector<Colour> emissions;  // by tag: power of a unit of area, or of a fog's volume, in the scene's units
  Shading shading;
  std::vector<Light> lights;
  std::vector<Colour> light_colours;
  Lighting lighting;
  View view;
  std::optional<Colour> background;

  VolumeView volume_view() const;  // with tags and gradients; points into this SceneSetup
  // The driver has its own copy after load_volume(): keeps the dimensions, gives the memory back.
  void free_voxels();
};

// Reads or makes the volume and completes what the scene leaves open: a volume file has a light
// above the viewer's left shoulder, the preset "ramp", and a camera that sees all that is visible. `threads` 0 = one a core. Throws InputError and FileError.
// With lighting and no lights there is one point light in the direction of `light`, outside of the volume.
SceneSetup set_up(const Scene& scene, int threads = 0);

// The same for another scene with the same voxels, which may have been freed: materials, lights, camera and view anew.
void set_look(const Scene& scene, SceneSetup& setup);

// Whether set_up() makes the same voxels and materials of both, so that one setup, and what was loaded of it, serves both.
bool same_voxels(const Scene& a, const Scene& b);
// Whether, beyond that, an illumination pass leaves the same irradiance: lights and settings are alike.
bool same_illumination(const Scene& a, const Scene& b);

// A type's name in files and options, "uint8" to "float32". Throws InputError that names `field`.
SampleType sample_type_named(const std::string& name, const std::string& field);

// Fills in eye, look_at, up, fov and height of `view` from `camera`; its image size gives the aspect ratio.
// look_at: the box's centre. up: +z, or +y if the line of sight runs along z. eye: in the direction (-0.35, -1, 0.45)
// from look_at in physical space, where `box` just fits into the image.
// Throws InputError for a field of view that is not within 0..180 degrees.
void fit_camera(const CameraSettings& camera, const VoxelBox& box, const Vec3& spacing, View& view);

// The direction towards a light above the viewer's left shoulder.
Vec3 shoulder_light(const View& view, const Vec3& spacing);

}  // namespace gicube::samples
