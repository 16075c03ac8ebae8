// The lights of a scene, and the settings of their illumination of the volume.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gicube/export.h"
#include "gicube/illumination.h"
#include "gicube/scene/voxeliser.h"
#include "gicube/transfer_function.h"

namespace gicube::scene {

struct SceneLight {
  std::string name{};
  Light light{};           // in the scene's units: world units, or voxels of a volume without a world
  Colour colour{1, 1, 1};  // linear factors of its power in colour passes
};

struct Lighting {
  bool on = false;  // false: the reflectance map lights the picture, lighting rays are not sent
  Illumination settings;
  // Brightness, a factor of colours, of a surface that receives one unit of power per unit of area, in the scene's
  // units; 0 = chosen by the driver for each pass.
  double exposure = 0;
  // Three passes and three pictures, which give red, green and blue: each has the lights' colours and the materials'
  // scattering_colour of its channel. Materials then colour the light; a single irradiance has no colour.
  bool colour_passes = false;
};

// Throws InputError with the light's fields: a direction or area of length 0, power or radius not above 0, not finite.
GICUBE_API void check(const SceneLight& light);

// In voxels of `grid`.
GICUBE_API Light in_voxels(Light light, const WorldGrid& grid);
// The light with its power, or irradiance, multiplied.
GICUBE_API Light scaled(Light light, double factor);

// Names in scene files and options: "none", "low" or "high"; "conserving" or "as-printed". Throw InputError that names
// `field`.
GICUBE_API void set_albedo(const std::string& name, const std::string& field, Lighting& lighting);
GICUBE_API EnergyRules rules_named(const std::string& name, const std::string& field);

}  // namespace gicube::scene
