// Pictures of several volumes and surfaces: the host divides viewing rays into segments between surfaces, boards trace
// the segments, and the host composites their colours.
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

// A volume with its voxels and its place: a box, or a shell.
struct StageMedium {
  std::string name;
  SceneSetup setup;
  Affine to_voxels;  // from the common space; not for shells
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

// Throws InputError and FileError with the volume's name.
Stage set_up(const Composition& composition, int threads = 0);

struct EyeRay {
  Vec3 origin, direction;  // unit length
};
// Ray through a point of the image, pixels from its top left corner. Like the driver's own viewing rays, in a space
// whose edges are 1.
EyeRay eye_ray(const View& view, double x, double y);

// Finds the pieces along a viewing ray.
void plan_ray(const Stage& stage, const EyeRay& ray, RayPlan& plan);

// Cost of a volume.
struct MediumCost {
  std::size_t board = 0;            // index of its board
  std::uint64_t rays = 0;           // viewing rays that meet it
  std::uint64_t segments = 0;       // host rays
  Picoseconds load = 0, trace = 0;  // simulated, of that board: the volume and its tables; its segments there and back
};

struct Picture {
  int width = 0, height = 0;
  std::vector<Premultiplied> pixels;  // rows from the top

  Image image() const;  // rounded to the framebuffer's bits
};

// The boards load and trace the volumes in turn; each volume replaces the last one on its board. Simulated hosts need
// no time to make rays and to composite. Shading, step and opacity threshold are the stage's. `told`: traced volumes.
// Throws what Board throws, and InputError for more than kMaxSegments.
Picture compose(const Stage& stage, std::vector<Board>& boards, std::vector<MediumCost>& costs,
                const Progress& told = {});

constexpr std::uint64_t kMaxSegments = std::uint64_t{1} << 26;  // chosen: 2 GiB of results in the host's memory

}  // namespace gicube::samples
