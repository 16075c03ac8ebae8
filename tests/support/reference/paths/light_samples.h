// Light that lamps send to a point, and the light of a lamp that a ray hits. In physical space.
#pragma once

#include <optional>
#include <vector>

#include "counter_random.h"
#include "path_scene.h"

namespace gicube::reference::paths {

// A light's position and edges in physical space, with its radiance.
Light to_physical(const Light& light, Vec3 spacing);

// A connection of a point with a random point of a light: summed over many, `weight` times what passes and is scattered
// towards `direction` is the light's part of the radiance.
struct LightSample {
  Vec3 direction;       // unit, towards the light
  double distance = 0;  // to it; infinite for distant lights
  double weight =
      0;  // radiance over the density per solid angle; of point and distant lights the irradiance across the ray
};
LightSample sample_light(const Light& light, Vec3 position, CounterRandom& random);

// Where a ray comes upon a rectangle or a sphere, from the side to which it shines, and the radiance that it finds.
struct LightHit {
  double distance = 0;
  double radiance = 0;
};
std::optional<LightHit> hit_light(const Light& light, Vec3 origin, Vec3 direction);

}  // namespace gicube::reference::paths
