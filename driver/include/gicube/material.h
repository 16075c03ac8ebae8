// The scattering of a material [P §2.2]. Its colour and opacity are its transfer function's.
#pragma once

#include <cstdint>
#include <vector>

#include "gicube/transfer_function.h"

namespace gicube {

// A ray of direction D that interacts with a material of normal N (against the gradient, facing the ray) goes on along
//   kNone           D: it is not scattered
//   kSpecular       R, the mirror image of -D about N
//   kDullReflection (R + gloss d) / |R + gloss d|, d a random direction
//   kDullScattering (D + gloss d) / |D + gloss d|
//   kIsotropic      d
//   kDiffuse        (N + d) / |N + d|: radiance alike in all directions of the half space (Lambert)
//   kTrap           by a routine: on the board's DSP, or in the application
enum class Bsdf { kNone, kSpecular, kDullReflection, kDullScattering, kIsotropic, kDiffuse, kTrap };

// Routines that every board has; gicube-board --bsdf adds more, numbered from kFirstUserRoutine on.
enum BoardRoutine : int {
  kFresnelRoutine = 0,           // dielectric surface; parameters: index of refraction (1.5 if none)
  kHenyeyGreensteinRoutine = 1,  // phase function; parameters: g, -1..1 exclusive (0 if none)
  kTabulatedRoutine = 2,         // phase function; parameters: up to 32 values of it at equal steps of cos from -1 to 1
  kFirstUserRoutine = 8,
  kHostRoutine = 255,  // the application: Board::set_scattering_routine()
};

struct Material {         // how a material scatters rays
  double scattering = 0;  // Ks, the share of an interaction that is scattered and not absorbed; 0..1
  Bsdf bsdf = Bsdf::kNone;
  double gloss = 0;  // beta of the dull kinds: 0 is sharp; 0..15.99
  // Rendering rays are scattered here too (View::scatter). Mirrors, glossy surfaces and glass; the other materials show
  // the irradiance that they hold.
  bool seen_through_scattering = false;
  int routine = 0;                  // kTrap only
  bool surface = false;             // kTrap only: a ray that was scattered passes until it has left the surface
  std::vector<float> parameters{};  // kTrap only: at most 32, for the routine
  // Factors of `scattering` for red, green and blue of lighting rays, 0..1; other than white only on a board of three
  // irradiance words (BoardInfo::irradiance_words). Rendering rays are scattered as the colour that is scattered most.
  Colour scattering_colour{1, 1, 1};
};

}  // namespace gicube
