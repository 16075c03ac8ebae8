// Materials of a scene's solids, fogs and scans: appearance and scattering of light.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gicube/material.h"
#include "gicube/scene/transfer_function_file.h"

namespace gicube::scene {

// Opaque, or of the opacity `opacity` per voxel length, within about one voxel of its surface.
struct SolidLook {
  Colour colour{1, 1, 1};
  double opacity = 1;
  friend bool operator==(const SolidLook&, const SolidLook&) = default;
};

// A participating medium, which transmits exp(-extinction s) over a length s.
struct FogLook {
  Colour colour{1, 1, 1};
  double extinction = 1;  // per world unit, > 0
  friend bool operator==(const FogLook&, const FogLook&) = default;
};

using MaterialLook = std::variant<SolidLook, FogLook, TransferFunctionFile>;

struct SceneMaterial {
  std::string name{};
  int tag = 0;  // 0..3, another for each material
  // The values of a transfer function are those of the scan's file, and run from 0 (outside) to 4095 for a solid.
  // Unset: a white solid, or the look that the volume has without materials.
  std::optional<MaterialLook> look{};
  Material optics{};
  // With Lighting::colour_passes: factors of optics.scattering in the passes of red, green and blue.
  Colour scattering_colour{1, 1, 1};
  // Emitted power per unit of a solid's surface, or of a fog's or scan's volume, in the scene's units. Only
  // gicube-form-factors uses it: Board::illuminate() has no such lights.
  double emission = 0;
  Colour emission_colour{1, 1, 1};  // linear factors of it
};

// The material's look if it is of that kind, otherwise nullptr.
template <typename Look>
const Look* look_as(const SceneMaterial& material) {
  return material.look ? std::get_if<Look>(&*material.look) : nullptr;
}

// The look in densities 0..4095, for voxels `voxel` world units long. A transfer function is returned unchanged.
GICUBE_API TransferFunctionFile transfer_function_of(const MaterialLook& look, double voxel);

// Throws InputError that names the field: a Ks above 1, a gloss or parameter out of range, a parameter without its
// BSDF.
GICUBE_API void check(const SceneMaterial& material);

// "none", "specular", "dull_reflection", "dull_scattering", "isotropic", "diffuse", "trap". Throws InputError.
GICUBE_API Bsdf bsdf_named(const std::string& name);
// "fresnel", "henyey_greenstein", "tabulated", "host", or a number from 0 to 255. Throws InputError.
GICUBE_API int routine_named(const std::string& name);

}  // namespace gicube::scene
