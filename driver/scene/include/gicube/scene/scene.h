// Scenes: as a user asked for one, from a file or by these structs, and the same one as voxels, ready for a board.
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

// Positions in the scene's units. What is not set is chosen to show the whole volume (fit_camera).
struct CameraSettings {
  std::string name;
  std::optional<Vec3> eye, look_at, up;
  std::string from;                           // a named view (see_from()), in place of `eye`
  std::optional<double> fov_degrees;          // vertical
  std::optional<double> orthographic_height;  // in (smallest) voxel edges; set = orthographic
};

// One function for all tags, or one a tag.
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
  std::optional<ValueRange> range;  // of a volume file's values, in place of what a survey of them finds
  std::optional<Phong> phong;
  std::optional<Vec3> light;  // towards the light of pictures without illumination; else the first directional of:
  std::vector<SceneLight> lights;
  Lighting lighting;
  CameraSettings camera;
  std::vector<CameraSettings> more_cameras;
  std::vector<Engine> engines;
  std::optional<Colour> background;
  bool own_codebook = true;  // worlds: normals are coded by a codebook of their own (codebook_of())
  View view;  // image and sampling, cut planes in the scene's units; the camera's fields are filled by set_up()
};

// Makes the camera of this name the scene's own. Throws InputError with the names of those that are there.
GICUBE_API void choose_camera(Scene& scene, const std::string& name);

// For a scene whose files are trusted: VolumeSource::allow_outside of all its volumes.
GICUBE_API void allow_outside(Scene& scene);

// Voxels, both ends included.
struct SceneBox {
  Vec3 low, high;
};

// Owns what a VolumeView points to. Everything in it is in voxels.
struct SceneSetup : VoxelWorld {
  WorldGrid grid;       // of the scene's units; the identity without a world
  SceneBox box;         // what the camera is to see, unless it is told
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

  std::optional<Survey> survey;  // of a volume file's values
  std::string look_why;  // of the automatic look: which it is, and why; empty: the look is the user's or the scene's
  // For a label map with automatic appearance, whose voxels are then 255 where there is a label, tagged by its colour:
  // each voxel's index in `label_values`, where 0 is the background. free_voxels() keeps them.
  std::vector<std::uint16_t> labels;
  std::vector<double> label_values;

  std::uint64_t voxel_hash = 0;     // of volume, tags and gradients, as set_up() made them
  std::vector<MaterialLook> looks;  // by tag: of the scene's materials; a world's without a look are white solids

  GICUBE_API VolumeView volume_view() const;  // with tags and gradients; points into this SceneSetup
  // The driver has its own copy after load_volume(): keeps the dimensions, gives the memory back.
  GICUBE_API void free_voxels();
};

// Reads or makes the volume and completes what the scene leaves open: a volume file has a light
// above the viewer's left shoulder, the look that automatic_look() finds, and a camera that sees the larger parts of
// what is visible. `threads` 0 = one a core. Throws InputError and FileError.
// With lighting and no lights there is one point light in the direction of `light`, outside of the volume.
GICUBE_API SceneSetup set_up(const Scene& scene, int threads = 0);

// Replaces materials, lights, camera and view by those of a scene with the same voxels, which may have been freed.
GICUBE_API void set_look(const Scene& scene, SceneSetup& setup);
// Whether that is right for a scene of the same voxels with another transfer function: not for a label map that gets or
// loses its automatic look, nor if the function has points beyond a range that leaves out extreme values.
GICUBE_API bool keeps_voxels(const Scene& scene, const SceneSetup& setup);

// For Provenance: of the voxels, the materials and the lights; not of camera and sampling. Holds after free_voxels()
// too.
GICUBE_API std::uint64_t scene_hash(const SceneSetup& setup);

// Whether set_up() makes the same voxels and materials of both, so that one setup, and what was loaded of it, serves
// both.
GICUBE_API bool same_voxels(const Scene& a, const Scene& b);
// Whether, beyond that, an illumination pass leaves the same irradiance: lights and settings are alike.
GICUBE_API bool same_illumination(const Scene& a, const Scene& b);

// The direction to the eye, and what is up unless `up` is set, of a named view: front, back, left, right, top, bottom
// or iso. With a patient they are the patient's, and anterior, posterior, superior and inferior are views too; the
// patient's left is then at +x, and his front is up as seen along z. Without one, left is the viewer's left in front,
// at -x. Throws InputError.
GICUBE_API Vec3 see_from(const std::string& name, WorldAxes axes, std::optional<Vec3>& up);

// Fills in eye, look_at, up, fov and height of `view` from `camera`; its image size gives the aspect ratio.
// look_at: the box's centre. up: +z, or +y if the line of sight runs along z. eye: towards `from`, or else in the
// direction (-0.35, -1, 0.45),
// from look_at in physical space, where `box` just fits into the image.
// Throws InputError for a field of view that is not within 0..180 degrees.
// `axes`: what `from` is said of.
GICUBE_API void fit_camera(const CameraSettings& camera, const SceneBox& box, const Vec3& spacing, View& view,
                           WorldAxes axes = WorldAxes::kNone);

// The direction towards a light above the viewer's left shoulder.
GICUBE_API Vec3 shoulder_light(const View& view, const Vec3& spacing);

GICUBE_API SceneBox whole_box(const Dims& dims);

// The smallest box around what the function makes visible, one voxel of margin included; the whole volume if nothing
// is. Pieces count that have a tenth of the largest one's voxels, in cells of 4^3 with at least 5 visible voxels each;
// if there are no such cells, all do.
GICUBE_API SceneBox visible_box(const Volume& volume, const TransferFunctionFile& file);

// The scene's voxels and how they look. A world's normals get a codebook of their own if `own_codebook` is set, which
// only a board without a volume can take. Shading, materials, lights and view are the caller's to set, from `setup` or
// otherwise. Throws what Board::load_volume(), set_gradient_codebook() and set_transfer_function() throw.
GICUBE_API void load(Board& board, const SceneSetup& setup, bool own_codebook, const Progress& progress = {});
// That codebook alone.
GICUBE_API void set_own_codebook(Board& board, const SceneSetup& setup);

// Scenes as protobuf text files (gicube/v1/scene.proto).

// Strict: an unknown field, a value of the wrong type, out of range or missing is an error. Throws InputError with all
// faults, one a line: "NAME:LINE:COLUMN: ..." for the text, "NAME: field.path: expected ..., got ..." for its meaning.
// Relative paths in `text` are taken from `folder`. A file that lies neither there nor below, links followed, is
// refused unless the text is trusted (`allow_outside`, which holds for the headers of its volumes too). Reads transfer
// functions, but not the volume.
GICUBE_API Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder);
GICUBE_API Scene parse_scene(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                             bool allow_outside);
// Reads a file. Also throws InputError if it cannot be read.
GICUBE_API Scene read_scene(const std::filesystem::path& path);
GICUBE_API Scene read_scene(const std::filesystem::path& path, bool allow_outside);

// Whether a path's extension is that of a scene: .scene, .textproto, .pbtxt or .txt.
GICUBE_API bool is_scene_path(const std::filesystem::path& path);

}  // namespace gicube::scene
