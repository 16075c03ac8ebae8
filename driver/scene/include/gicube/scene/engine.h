// Parameters that time drives, as the engines of [P §4.1]: an animation is a scene at several times.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gicube/export.h"

namespace gicube::scene {

struct Scene;

struct EngineKey {
  double time = 0;  // seconds
  double value = 0;
};

// Drives one number of the scene, named by its place:
//   node[NAME].transform[I].translate.x   .rotate.degrees   .rotate.axis.x   .scale.x
//   node[NAME].hypertexture.softness   .frequency   .amplitude   .time   .length   .curl   .stretch
//   light[NAME or I].power  .towards.x  .position.x  .corner.x  .edge_u.x  .edge_v.x  .centre.x  .radius
//   camera.eye.x   .look_at.x   .up.x   .fov_degrees   .orthographic_height      also camera[NAME].
//   cut_plane[I].normal.x   .offset
// (.x, .y or .z.) What the scene leaves open, such as a camera without an eye, can't be driven.
struct Engine {
  std::string target{};
  // Linear between its keys, constant before the first and after the last; times rise strictly. Empty: start + rate t.
  std::vector<EngineKey> keys{};
  double start = 0, rate = 0;  // a second

  GICUBE_API double at(double time) const;
};

// Throws InputError: no target, keys that do not rise, numbers that are not finite.
GICUBE_API void check(const Engine& engine);

// The number that `target` names. Throws InputError: none of that name.
GICUBE_API double& find_parameter(Scene& scene, const std::string& target);

// The scene with all its engines' values of that time. Throws InputError as find_parameter() does, and for two engines
// with one target.
GICUBE_API Scene at_time(const Scene& scene, double time);

}  // namespace gicube::scene
