// The routines that every board has. Each is a pure function of its event and its parameters.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "datapath/scattering.h"

namespace gicube::emu {

// chosen: a ray to the DSP and back (24 cycles, as for an overflow), and some hundred operations. A C6205 starts up to
// eight per cycle, but divisions, roots and sines need iterations.
inline constexpr std::uint32_t kBuiltInCycles = 200;

struct BuiltIn {
  const char* name;
  std::optional<std::string> (*fault)(std::span<const float> parameters);
  ScatterAnswer (*scatter)(const ScatterEvent& event);  // requires parameters without a fault
};

// Dielectric surface. The normal points into vacuum; the other side has the index of refraction parameters[0] (default:
// 1.5). Unpolarised light is reflected with the probability of Fresnel's reflectance, and otherwise refracted by
// Snell's law. Beyond the critical angle all light is reflected. Without a normal, the ray continues. Born and Wolf,
// Principles of Optics, §1.5.2.
extern const BuiltIn kFresnel;
double fresnel_reflectance(double cosine, double index_from, double index_to);  // cosine of incidence, 0..1

// Phase function (1 - g^2) / (1 + g^2 - 2 g cos)^(3/2) / 4 pi, g = parameters[0] (default: 0), -1 < g < 1; sampled
// exactly. Henyey and Greenstein, Diffuse Radiation in the Galaxy, ApJ 93, 1941.
extern const BuiltIn kHenyeyGreenstein;

// Phase function by its values: 1 to 32 of them, of any scale, at equal steps of the scattering angle's cosine from -1
// to 1, with linear interpolation; sampled exactly.
extern const BuiltIn kTabulated;

// The routine with this number, or null.
const BuiltIn* built_in(std::uint8_t number);

}  // namespace gicube::emu
