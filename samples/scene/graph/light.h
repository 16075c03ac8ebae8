// The lights of a scene, and how they are spread into its volume.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gicube/illumination.h"
#include "gicube/transfer_function.h"
#include "scene/geometry/voxel_world.h"

namespace gicube::samples {

struct SceneLight {
  std::string name{};
  Light light{};           // in the scene's units: world units, or voxels of a volume without a world
  Colour colour{1, 1, 1};  // linear factors of its power in colour passes
};

struct Lighting {
  bool on = false;  // false: the reflectance map lights the picture, lighting rays are not sent
  Illumination settings;
  // Brightness (colours are multiplied by it) of a surface that a unit of power reaches on a unit of its area, in the
  // scene's units; 0 = chosen by the driver for each pass.
  double exposure = 0;
  // Three passes and three pictures, of which red, green and blue are taken: each with the lights' and the materials'
  // scattering_colour in that channel. Light is then coloured by what it met; irradiance alone has no colour.
  bool colour_passes = false;
};

// Throws InputError with the light's fields: a direction or area of length 0, power or radius not above 0, not finite.
void check(const SceneLight& light);

// In voxels of `grid`.
Light in_voxels(Light light, const WorldGrid& grid);
// The same with all its power, or irradiance, multiplied.
Light scaled(Light light, double factor);

// Names in scene files and options: "none", "low" or "high"; "conserving" or "as-printed". Throw InputError that names `field`.
void set_albedo(const std::string& name, const std::string& field, Lighting& lighting);
EnergyRules rules_named(const std::string& name, const std::string& field);

}  // namespace gicube::samples
