// How a material spreads light beneath its surface, measured by photons through a slab of it.
#pragma once

#include <cstdint>
#include <vector>

#include "transport/flights.h"

namespace gicube::samples {

struct ProfileSettings {
  std::uint64_t photons = 200'000;
  double radius = 0;      // voxel edges: of the outermost ring; 0: a quarter of the slab's shorter side
  int rings = 40;         // their radii grow as squares
  bool straight = false;  // light comes straight down; else from all of the half space alike (Lambert)
  int max_scatterings = 10'000;
  double step = 0.5;  // voxels between the board's samples
  std::uint64_t seed = 0;
};

// Shares of the light that falls on one point of a slab's top, by channel. Lengths in smallest voxel edges.
class Profile {
 public:
  struct Ring {
    double inner = 0, outer = 0;
    Rgb share{}, error{};  // what comes out of it; its standard error
  };
  std::vector<Ring> rings;
  // With standard errors. All that comes out of the top, also beyond the rings; what leaves at the bottom; and at the slab's sides:
  // a slab too narrow for the profile.
  Rgb reflected{}, reflected_error{}, transmitted{}, transmitted_error{}, sideways{}, sideways_error{};
  std::uint64_t photons = 0, rays = 0;

  Rgb at(double radius) const;      // on a unit of area; linear between the rings' middles, 0 beyond them
  Rgb within(double radius) const;  // of the rings, up to there
};

// The slab is the whole volume, of media; its top is the face of greatest z. Photons fall on the middle half of each of its sides, at random,
// so that the profile of a scanned or procedural material is that of its mean. The board flies them from one scattering to the next.
Profile measure_profile(Board& board, const Medium& medium, const ProfileSettings& settings);

// The dipole of Jensen, Marschner, Levoy and Hanrahan 2001 for an even half space of the same index as what is above: `extinction` per
// length, albedo, mean cosine. On a unit of area.
double dipole(double extinction, double albedo, double g, double radius);
double dipole_reflected(double albedo, double g);  // all of it

}  // namespace gicube::samples
