#include "gicube/scene/material.h"

#include <cmath>
#include <utility>

#include "gicube/scene/voxeliser.h"
#include "scene/common/checks.h"

namespace gicube::scene {
namespace {

constexpr double kMaxGloss = 15.99;  // as Material::gloss
constexpr std::size_t kMaxParameters = 32;

TransferFunctionFile look_of(const SolidLook& solid, double) {
  return {{{{0, solid.colour}}, {{0.3 * kMaxDensity, 0}, {0.7 * kMaxDensity, solid.opacity}}}};
}

// The opacity increases with the density, up to the density that voxelise() gives a fog.
TransferFunctionFile look_of(const FogLook& fog, double voxel) {
  const double opacity = 1 - std::exp(-fog.extinction * voxel);
  return {{{{0, fog.colour}}, {{0, 0}, {std::round(kFogDensity * kMaxDensity), opacity}}}};
}

TransferFunctionFile look_of(const TransferFunctionFile& function, double) { return function; }

void check_colour(const char* field, const Colour& colour) {
  for (const double part : colour) require(part >= 0 && part <= 1, field, "numbers from 0 to 1", part);
}

}  // namespace

TransferFunctionFile transfer_function_of(const MaterialLook& look, double voxel) {
  return std::visit([voxel](const auto& l) { return look_of(l, voxel); }, look);
}

void check(const SceneMaterial& material) {
  require(material.tag >= 0 && material.tag <= 3, "tag", "0 to 3", material.tag);
  if (const auto* solid = look_as<SolidLook>(material)) {
    check_colour("solid.colour", solid->colour);
    require(solid->opacity >= 0 && solid->opacity <= 1, "solid.opacity", "0 to 1", solid->opacity);
  }
  if (const auto* fog = look_as<FogLook>(material)) {
    check_colour("fog.colour", fog->colour);
    require_above_0("fog.extinction", fog->extinction);
  }
  const Material& optics = material.optics;
  require(optics.scattering >= 0 && optics.scattering <= 1, "scattering", "0 to 1", optics.scattering);
  check_colour("scattering_colour", material.scattering_colour);
  require(material.emission >= 0 && std::isfinite(material.emission), "emission", "a number, 0 or more",
          material.emission);
  check_colour("emission_colour", material.emission_colour);
  require(optics.gloss >= 0 && optics.gloss <= kMaxGloss, "gloss", "0 to 15.99", optics.gloss);
  require(optics.scattering == 0 || optics.bsdf != Bsdf::kNone, "bsdf", "another than none with scattering",
          optics.scattering);
  const bool dull = optics.bsdf == Bsdf::kDullReflection || optics.bsdf == Bsdf::kDullScattering;
  require(optics.gloss == 0 || dull, "gloss", "0 but for dull_reflection and dull_scattering", optics.gloss);
  const bool trap = optics.bsdf == Bsdf::kTrap;
  require(trap || (optics.routine == 0 && !optics.surface), "routine", "only with bsdf: \"trap\"", optics.routine);
  require(trap || optics.parameters.empty(), "parameter", "only with bsdf: \"trap\"",
          static_cast<double>(optics.parameters.size()));
  require(optics.parameters.size() <= kMaxParameters, "parameter", "at most 32 numbers",
          static_cast<double>(optics.parameters.size()));
  for (const float parameter : optics.parameters) {
    require(std::isfinite(parameter), "parameter", "finite numbers", parameter);
  }
}

Bsdf bsdf_named(const std::string& name) {
  return named<Bsdf>("bsdf", name,
                     {{"none", Bsdf::kNone},
                      {"specular", Bsdf::kSpecular},
                      {"dull_reflection", Bsdf::kDullReflection},
                      {"dull_scattering", Bsdf::kDullScattering},
                      {"isotropic", Bsdf::kIsotropic},
                      {"diffuse", Bsdf::kDiffuse},
                      {"trap", Bsdf::kTrap}});
}

int routine_named(const std::string& name) {
  static constexpr std::pair<const char*, int> kNames[] = {{"fresnel", kFresnelRoutine},
                                                           {"henyey_greenstein", kHenyeyGreensteinRoutine},
                                                           {"tabulated", kTabulatedRoutine},
                                                           {"host", kHostRoutine}};
  for (const auto& [text, routine] : kNames) {
    if (name == text) return routine;
  }
  const auto number = parse_number<int>(name);
  if (!number || *number < 0 || *number > 255) {
    throw InputError("routine", "fresnel, henyey_greenstein, tabulated, host or a number from 0 to 255",
                     in_quotes(name));
  }
  return *number;
}

}  // namespace gicube::scene
