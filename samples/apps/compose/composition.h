// Several volumes and surfaces in one space, described by the user (gicube/v1/composition.proto).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compose/shell.h"
#include "gicube/scene/mesh.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace gicube::samples {

struct PlacedVolume {
  std::string name;  // for messages and statistics
  Scene scene;
  Affine to_space;  // from the volume's own space: a world's units, or scan_space()
};

struct PlacedSurface {
  std::string name;
  Mesh mesh;  // in the common space
  Colour colour{1, 1, 1};
  double opacity = 1;  // of one crossing
};

// A mesh covered by a thick layer of a volume (compose/shell.h).
struct PlacedShell {
  std::string name;
  Scene scene;
  Mesh mesh;  // in the common space, with texture coordinates
  ShellSettings settings;
};

struct Composition {
  std::vector<PlacedVolume> volumes;
  std::vector<PlacedShell> shells;
  std::vector<PlacedSurface> surfaces;
  CameraSettings camera;      // unset fields are chosen to show everything
  Phong phong;                // of volumes and surfaces
  std::optional<Vec3> light;  // towards it; unset: above the viewer's left shoulder
  View view;  // image size, samples, step (voxels of each volume), opacity_threshold; set_up() sets the camera
  double overlap_step = 1;  // voxels
  std::optional<Colour> background;
};

// Strict like read_scene(): throws InputError with all errors, each with its line or field. Reads the named scenes,
// transfer functions and meshes, but no volumes. `allow_outside`: as for parse_scene().
Composition parse_composition(const std::string& text, const std::string& name, const std::filesystem::path& folder,
                              bool allow_outside = false);
Composition read_composition(const std::filesystem::path& path, bool allow_outside = false);

}  // namespace gicube::samples
