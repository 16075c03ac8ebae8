// What the path tracer takes: the scene of a picture, and what its materials and lights do.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "gicube/illumination.h"
#include "gicube/material.h"
#include "reference/scene.h"

namespace gicube::reference::paths {

// Not the reference march's own.
using gicube::Light;
using gicube::Material;

using Rgb = std::array<double, 3>;

// Lights as the board has them: positions in voxels, lengths in smallest voxel edges. They stop no ray.
struct PathScene {
  Scene scene;                          // volume and functions; of the view its camera, size and cut planes
  std::array<Material, 4> materials{};  // by tag
  std::array<Rgb, 4> scattering_colours{
      {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};  // factors of Material::scattering
  std::vector<Light> lights{};
  std::vector<Rgb> light_colours{};                  // one for each light
  std::function<Rgb(Vec3 direction)> environment{};  // radiance that a ray finds which leaves along it; none if empty
  // Of tags that are solids with a sharp surface: the value from which on they are, whatever their opacity (diffuse,
  // specular, glass).
  std::array<std::optional<double>, 4> surfaces{};
  // Their normal is that of differences over this many voxels to both sides; 0: the field's own gradient, which jumps
  // between cells.
  double normal_reach = 0;
  // What full opacity is taken for: extinction per smallest voxel edge. A solid's surface is soft by its inverse.
  double max_extinction = 16;
  int max_scatterings = 1 << 20;  // of a path; the light of longer ones is missing
  // The greatest radiance that the eye has of a light which it sees in mirrors and glass alone.
  double max_seen = std::numeric_limits<double>::infinity();
  bool sees_lights = false;  // rays straight from the eye see rectangles and spheres; reflected ones always do
};

}  // namespace gicube::reference::paths
