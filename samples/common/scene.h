// What a sample draws: a scene as its user asked for it, and the same scene ready for the board.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/transfer_function_file.h"
#include "common/visible_box.h"
#include "common/volume_file.h"
#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube::samples {

// Positions in voxels. What is not set is chosen to show the whole volume (fit_camera).
struct CameraSettings {
  std::optional<Vec3> eye, look_at, up;
  std::optional<double> fov_degrees;          // vertical
  std::optional<double> orthographic_height;  // in (smallest) voxel edges; set = orthographic
};

struct VolumeSource {
  std::string builtin;           // "buckyball", or empty
  std::filesystem::path file;    // a file or a folder of slices
  int size = 256;                // voxels an edge, builtin only
  std::optional<RawLayout> raw;  // headerless files only
  std::optional<Vec3> spacing;   // overrides the file's
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

struct Scene {
  VolumeSource volume;
  std::optional<TransferFunctionFile> transfer_function;  // for every tag
  std::optional<Phong> phong;
  std::optional<Vec3> light;  // towards the light
  CameraSettings camera;
  View view;  // image and sampling; the camera's fields are filled by set_up()
};

// Owns what a VolumeView points to.
struct SceneSetup {
  Volume volume;
  std::vector<std::uint8_t> tags;
  std::vector<float> gradients;
  Materials materials;
  Shading shading;
  View view;
  std::optional<Colour> background;

  VolumeView volume_view() const;  // with tags and gradients; points into this SceneSetup
  // The driver has its own copy after load_volume(): keeps the dimensions, gives the memory back.
  void free_voxels();
};

// Reads or makes the volume and completes what the scene leaves open: a volume file has a light
// above the viewer's left shoulder, the preset "ramp", and a camera that sees all that is visible. `threads` 0 = one a core. Throws InputError and FileError.
SceneSetup set_up(const Scene& scene, int threads = 0);

// A type's name in files and options, "uint8" to "float32". Throws InputError that names `field`.
SampleType sample_type_named(const std::string& name, const std::string& field);

// Fills in eye, look_at, up, fov and height of `view` from `camera`; its image size gives the aspect ratio.
// look_at: the box's centre. up: +z, or +y if the line of sight runs along z. eye: in the direction (-0.35, -1, 0.45)
// from look_at in physical space, where `box` just fits into the image.
// Throws InputError for a field of view that is not within 0..180 degrees.
void fit_camera(const CameraSettings& camera, const VoxelBox& box, const Vec3& spacing, View& view);

// Towards a light above the left shoulder of who looks along `view`.
Vec3 shoulder_light(const View& view, const Vec3& spacing);

}  // namespace gicube::samples
