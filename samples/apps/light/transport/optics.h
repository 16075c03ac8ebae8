// Scattering of a path by a material (gicube/material.h): a random direction and its density.
#pragma once

#include <array>
#include <string>

#include "gicube/material.h"
#include "light/transport/random.h"

namespace gicube::samples {

using Rgb = std::array<double, 3>;

// A medium fills space and scatters anywhere in it. The others are surfaces, where the material's opacity reaches half
// of its greatest.
enum class Look { kMedium, kOpaque, kGlass };

struct Optics {
  Look look = Look::kMedium;
  Bsdf bsdf = Bsdf::kNone;
  Rgb albedo{};      // share of the light that is scattered
  double g = 0;      // media: the phase function's mean cosine (Henyey, Greenstein)
  double index = 1;  // glass: of refraction

  bool sharp() const { return look == Look::kGlass || bsdf == Bsdf::kSpecular; }
};

// Throws InputError (`name`: the material's): a BSDF that paths can't follow.
Optics optics_of(const Material& material, const std::array<double, 3>& colour, const std::string& name);

// `normal`: outward normal of a surface; not used for media. Directions are unit vectors.
Vec3 scatter(const Optics& optics, Vec3 direction, Vec3 normal, PathRandom& random);

// Density of `out`, per solid angle; 0 for sharp materials. Multiplied by the albedo it is the share of light that is
// scattered along `out`. The reverse direction has the same density, except for the cosine at a surface.
double density(const Optics& optics, Vec3 direction, Vec3 normal, Vec3 out);

}  // namespace gicube::samples
