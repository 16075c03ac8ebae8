// Pictures of several volumes and surfaces: the host makes a segment of each viewing ray for each piece between
// surfaces, boards trace the segments, and the host puts their colours over one another.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "compose/composition.h"
#include "compose/ray_plan.h"
#include "gicube/board.h"
#include "gicube/scene/affine.h"
#include "meshes/mesh_caster.h"

namespace gicube::samples {

// A volume with its voxels, and where it is: in a box, or all over a shell.
struct StageMedium {
  std::string name;
  SceneSetup setup;
  Affine to_voxels;  // from the common space, unless it is a shell's
  std::shared_ptr<const Shell> shell{};
};

// A composition as voxels and triangles.
struct Stage {
  std::vector<StageMedium> media;
  std::vector<PlacedSurface> surfaces;  // without their meshes, which `meshes` has
  std::shared_ptr<const MeshCaster> meshes;
  View view;   // in the common space, whose edges are 1
  Vec3 light;  // towards it
  Phong phong;
  double overlap_step = 1;  // voxels
};

// Throws InputError and FileError: of a volume, by its name.
Stage set_up(const Composition& composition, int threads = 0);

struct EyeRay {
  Vec3 origin, direction;  // unit length
};
// Through a point of the image, pixels from its top left corner. As the driver's own viewing rays, in a space whose
// edges are 1.
EyeRay eye_ray(const View& view, double x, double y);

// Finds the pieces along a viewing ray.
void plan_ray(const Stage& stage, const EyeRay& ray, RayPlan& plan);

// The cost of a volume.
struct MediumCost {
  std::size_t board = 0;            // which board traced it
  std::uint64_t rays = 0;           // viewing rays that meet it
  std::uint64_t segments = 0;       // host rays
  Picoseconds load = 0, trace = 0;  // simulated, of that board: the volume and its tables; its segments there and back
};

struct Picture {
  int width = 0, height = 0;
  std::vector<Premultiplied> pixels;  // rows from the top

  Image image() const;  // rounded to the framebuffer's bits
};

// Each volume is loaded by one of the boards in turn, traced, and makes room for the next. Their simulated hosts make
// rays and put colours together in no time. Shading, step and opacity threshold are those of the stage. `told`: volumes
// traced. Throws what Board throws, and InputError where more than kMaxSegments would be kept.
Picture compose(const Stage& stage, std::vector<Board>& boards, std::vector<MediumCost>& costs,
                const Progress& told = {});

constexpr std::uint64_t kMaxSegments = std::uint64_t{1} << 26;  // chosen: 2 GiB of results in the host's memory

}  // namespace gicube::samples
