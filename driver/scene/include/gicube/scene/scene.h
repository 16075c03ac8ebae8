// Scenes: as described by a file or by these structs, and as voxels that are ready for a board.
//
//   #include <gicube/scene/image_file.h>                 // for write_png()
//   Scene scene = read_scene("room.scene");
//   SceneSetup setup = set_up(scene);                    // or of at_time(scene, seconds)
//   load(board, setup, true);
//   board.set_shading(setup.shading);
//   board.illuminate(setup.lights, setup.lighting.settings);   // after set_material() of setup.optics
//   write_png(board.render(setup.view), "room.png", setup.background);
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/board.h"
#include "gicube/scene/engine.h"
#include "gicube/scene/light.h"
#include "gicube/scene/material.h"
#include "gicube/scene/survey.h"
#include "gicube/scene/transfer_function_file.h"
#include "gicube/scene/volume_file.h"
#include "gicube/scene/world.h"
#include "gicube/shading.h"
#include "gicube/transfer_function.h"
#include "gicube/view.h"
#include "gicube/volume.h"

namespace gicube::scene {

// Positions in the scene's units. Fields that are not set are chosen to show the whole volume (fit_camera).
struct CameraSettings {
  std::string name;
  std::optional<Vec3> eye, look_at, up;
  std::string from;                           // a named view (see_from()), in place of `eye`
  std::optional<double> fov_degrees;          // vertical
  std::optional<double> orthographic_height;  // in (smallest) voxel edges; set = orthographic
};

// One function for all tags, or one for each tag.
using Materials = std::vector<TransferFunctionFile>;

// The appearance of a built-in scene; a user's settings take precedence.
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
  std::optional<ValueRange> range;  // of a volume file's values, in place of the one that a survey finds
  std::optional<Phong> phong;
  std::optional<Vec3> light;  // towards the light of pictures without illumination; unset: the first directional of:
  std::vector<SceneLight> lights;
  Lighting lighting;
  CameraSettings camera;
  std::vector<CameraSettings> more_cameras;
  std::vector<Engine> engines;
  std::optional<Colour> background;
  bool own_codebook = true;  // worlds: normals are coded with their own codebook (codebook_of())
  View view;  // image and sampling, cut planes in the scene's units; the camera's fields are filled by set_up()
};

// Makes the camera of this name the scene's first. Throws InputError with the existing names if there is none.
GICUBE_API void choose_camera(Scene& scene, const std::string& name);

// Sets VolumeSource::allow_outside of all volumes, for a scene whose files are trusted.
GICUBE_API void allow_outside(Scene& scene);

// Voxels, both ends included.
struct SceneBox {
  Vec3 low, high;
};

// Owns the memory that a VolumeView points to. All positions and lengths in it are voxels.
struct SceneSetup : VoxelWorld {
  WorldGrid grid;       // of the scene's units; the identity without a world
  SceneBox box;         // shown by the camera unless the scene sets one
  Appearance built_in;  // of a built-in volume, or of a file's preset

  Materials materials;
  std::vector<Material> optics;            // by tag
  std::vector<Colour> scattering_colours;  // by tag
  std::vector<Colour> emissions;           // by tag: power per unit of area, or of a fog's volume, in the scene's units
  Shading shading;
  std::vector<Light> lights;
  std::vector<Colour> light_colours;
  Lighting lighting;
  View view;
  std::optional<Colour> background;

  std::optional<Survey> survey;  // of a volume file's values
  std::string look_why;  // names the automatic look and its reason; empty: the look is the user's or the scene's
  // Each voxel's index in `label_values`, where 0 is the background. Only for label maps with automatic appearance:
  // labelled voxels have the value 255 and the tag of their colour. free_voxels() keeps them.
  std::vector<std::uint16_t> labels;
  std::vector<double> label_values;

  std::uint64_t voxel_hash = 0;     // of volume, tags and gradients, as set_up() made them
  std::vector<MaterialLook> looks;  // by tag: of the scene's materials; a world's without a look are white solids

  GICUBE_API VolumeView volume_view() const;  // with tags and gradients; points into this SceneSetup
  // Frees the memory of the voxels but keeps the dimensions: the driver has its own copy after load_volume().
  GICUBE_API void free_voxels();
};

// Reads or makes the volume and chooses what the scene does not set: a volume file gets a light above the viewer's left
// shoulder, the look of automatic_look(), and a camera that shows the larger visible parts. With lighting and no
// lights, there is one point light in the direction of `light`, outside the volume. `threads`: 0 = one per core. Throws
// InputError and FileError.
GICUBE_API SceneSetup set_up(const Scene& scene, int threads = 0);

// Replaces materials, lights, camera and view with those of a scene with the same voxels, which may have been freed.
GICUBE_API void set_look(const Scene& scene, SceneSetup& setup);
// Whether set_look() suffices for a scene of the same voxels with another transfer function. It does not for a label
// map that gets or loses its automatic look, nor if the function has points beyond a range that omits extreme values.
GICUBE_API bool keeps_voxels(const Scene& scene, const SceneSetup& setup);

// A hash of voxels, materials and lights, without camera and sampling, for Provenance. Valid after free_voxels() too.
GICUBE_API std::uint64_t scene_hash(const SceneSetup& setup);

// Whether set_up() makes the same voxels and materials for both, so that one setup, and its loaded volume, serves both.
GICUBE_API bool same_voxels(const Scene& a, const Scene& b);
// Whether moreover an illumination pass makes the same irradiance: lights and settings are equal.
GICUBE_API bool same_illumination(const Scene& a, const Scene& b);

// The direction to the eye of a named view: front, back, left, right, top, bottom or iso; sets `up` unless it is set.
// With a patient these are the patient's sides, and anterior, posterior, superior and inferior are views too; the
// patient's left is at +x, and views along z have the front on top. Without a patient, left is at -x, on the left as
// seen from the front. Throws InputError.
GICUBE_API Vec3 see_from(const std::string& name, WorldAxes axes, std::optional<Vec3>& up);

// Fills in eye, look_at, up, fov and height of `view` from `camera`; the image size gives the aspect ratio. Defaults:
// look_at is the box's centre; up is +z, or +y if the line of sight runs along z; the eye is in the direction of the
// view `from`, or (-0.35, -1, 0.45) in physical space, at the distance from look_at where `box` just fits into the
// image. `axes`: those that `from` refers to. Throws InputError for a field of view outside 0..180 degrees.
GICUBE_API void fit_camera(const CameraSettings& camera, const SceneBox& box, const Vec3& spacing, View& view,
                           WorldAxes axes = WorldAxes::kNone);

// The direction towards a light above the viewer's left shoulder.
GICUBE_API Vec3 shoulder_light(const View& view, const Vec3& spacing);

GICUBE_API SceneBox whole_box(const Dims& dims);

// The smallest box around all that the function makes visible, with a margin of one voxel; the whole volume if nothing
// is visible. A connected piece counts if it has at least a tenth of the largest one's voxels, in cells of 4^3 with at
// least 5 visible voxels each; without such cells, all visible voxels count.
GICUBE_API SceneBox visible_box(const Volume& volume, const TransferFunctionFile& file);

// Loads the scene's voxels and transfer functions. With `own_codebook`, a world's normals get their own codebook, which
// requires a board without a volume. The caller sets shading, materials, lights and view. Throws what
// Board::load_volume(), set_gradient_codebook() and set_transfer_function() throw.
GICUBE_API void load(Board& board, const SceneSetup& setup, bool own_codebook, const Progress& progress = {});
// Sets only that codebook.
GICUBE_API void set_own_codebook(Board& board, const SceneSetup& setup);

// Scenes as protobuf text files (gicube/v1/scene.proto).

// An unknown field, or a value that is missing, out of range or of the wrong type, is an error. Throws InputError with
// all faults, one per line: "NAME:LINE:COLUMN: ..." for syntax, "NAME: field.path: expected ..., got ..." for values.
// Relative paths in `text` are relative to `folder`. A file that lies neither there nor below, after following links,
// is refused unless the text is trusted (`allow_outside`, which holds for the headers of its volumes too). Reads
// transfer functions, but not the volume.
GICUBE_API Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder);
GICUBE_API Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                             bool allow_outside);
// Reads a file. Also throws InputError if the file cannot be read.
GICUBE_API Scene read_scene(const std::filesystem::path& path);
GICUBE_API Scene read_scene(const std::filesystem::path& path, bool allow_outside);

// Whether a path's extension is that of a scene: .scene, .textproto, .pbtxt or .txt.
GICUBE_API bool is_scene_path(const std::filesystem::path& path);

}  // namespace gicube::scene
