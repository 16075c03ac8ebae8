// The routines that every board has. Each is a pure function of its event and its parameters.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "datapath/scattering.h"

namespace gicube::emu {

// chosen: a trap in and out of the DSP (24 cycles, as an overflow and back) and some hundred operations of a C6205,
// which begins up to eight a cycle but must iterate for divisions, roots and sines.
inline constexpr std::uint32_t kBuiltInCycles = 200;

struct BuiltIn {
  const char* name;
  std::optional<std::string> (*fault)(std::span<const float> parameters);
  ScatterAnswer (*scatter)(const ScatterEvent& event);  // only with parameters that have no fault
};

// Dielectric surface. The normal's side is vacuum, the other has the index of refraction parameters[0] (1.5 if none).
// Unpolarised light is mirrored with the probability of Fresnel's reflectance, else refracted by Snell's law; beyond
// the critical angle it is mirrored always. Without a normal the ray goes on. Born and Wolf, Principles of Optics,
// §1.5.2.
extern const BuiltIn kFresnel;
double fresnel_reflectance(double cosine, double index_from, double index_to);  // cosine of incidence, 0..1

// Phase function (1 - g^2) / (1 + g^2 - 2 g cos)^(3/2) / 4 pi, g = parameters[0] (0 if none), -1 < g < 1; sampled
// exactly. Henyey and Greenstein, Diffuse Radiation in the Galaxy, ApJ 93, 1941.
extern const BuiltIn kHenyeyGreenstein;

// Phase function of the scattering angle: 1 to 32 values at equal steps of its cosine from -1 to 1, linear between
// them, of any scale; sampled exactly.
extern const BuiltIn kTabulated;

// The one of that number, or null.
const BuiltIn* built_in(std::uint8_t number);

}  // namespace gicube::emu
