// Parameters driven by time, the engines of [P §4.1]: an animation is a scene at several times.
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

// Drives one number of the scene, which a path names:
//   node[NAME].transform[I].translate.x   .rotate.degrees   .rotate.axis.x   .scale.x
//   node[NAME].hypertexture.softness   .frequency   .amplitude   .time   .length   .curl   .stretch
//   light[NAME or I].power  .towards.x  .position.x  .corner.x  .edge_u.x  .edge_v.x  .centre.x  .radius
//   camera.eye.x   .look_at.x   .up.x   .fov_degrees   .orthographic_height      also camera[NAME].
//   cut_plane[I].normal.x   .offset
// (.x, .y or .z.) A number that the scene does not set, such as the eye of a camera without one, cannot be driven.
struct Engine {
  std::string target{};
  // Linear between the keys, constant before the first and after the last; times increase strictly. Empty: the value is
  // start + rate * time.
  std::vector<EngineKey> keys{};
  double start = 0, rate = 0;  // rate: per second

  GICUBE_API double at(double time) const;
};

// Throws InputError: no target, times of keys that do not increase, numbers that are not finite.
GICUBE_API void check(const Engine& engine);

// The number that `target` names. Throws InputError if there is none.
GICUBE_API double& find_parameter(Scene& scene, const std::string& target);

// The scene with its engines' values at that time. Throws InputError like find_parameter(), and for two engines with
// the same target.
GICUBE_API Scene at_time(const Scene& scene, double time);

}  // namespace gicube::scene
