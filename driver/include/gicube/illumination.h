// Volumetric global illumination: lights, and the pass that distributes their energy into the volume [P §2.2].
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "gicube/transfer_function.h"
#include "gicube/vector.h"

namespace gicube {

// Positions in voxels, directions and lengths physical (in smallest voxel edges, axes parallel to the voxel axes).
struct PointLight {
  Vec3 position;     // inside the volume or outside
  double power = 1;  // > 0, all lights of a pass in one unit
  friend bool operator==(const PointLight&, const PointLight&) = default;
};

struct DirectionalLight {  // a distant light
  Vec3 towards;            // from the scene to the light; any length but 0
  double irradiance = 1;   // > 0, power on a unit area across the light
  friend bool operator==(const DirectionalLight&, const DirectionalLight&) = default;
};

// Shines to the side of edge_u x edge_v, each point by Lambert's law.
struct RectangleLight {
  Vec3 corner;
  Vec3 edge_u, edge_v;  // physical; not parallel, not 0
  double power = 1;
  friend bool operator==(const RectangleLight&, const RectangleLight&) = default;
};

struct SphereLight {  // shines outward from its surface, Lambert
  Vec3 centre;
  double radius = 1;  // physical, > 0
  double power = 1;
  friend bool operator==(const SphereLight&, const SphereLight&) = default;
};

using Light = std::variant<PointLight, DirectionalLight, RectangleLight, SphereLight>;

// kLow: every ray deposits a part of its energy at each sample. kHigh: rays are photons that deposit all of it once.
enum class Albedo { kLow, kHigh };
// kAsPrinted: the paper's own rules, which lose scattered energy and count a point light four times.
// kConserving: energy is conserved (docs/reference/hardware.md, H901).
enum class EnergyRules { kAsPrinted, kConserving };

struct Illumination {  // how light is spread
  Albedo albedo = Albedo::kLow;
  EnergyRules rules = EnergyRules::kConserving;
  // k, 1..4096: rays through each cell between four voxels of a face of the volume, (N - 1)^2 of them a face. A light
  // inside sends rays through all six faces, one outside through those that it sees.
  int rays_per_face_voxel = 1;
  double step = 0.5;    // voxels along the ray, 1/64..16; refused as View::step
  bool jitter = false;  // of rays with the printed rules; the conserving ones don't depend on where samples lie
  bool leap = true;
  int lifetime = 32;       // scatterings until a ray is given up, 0..1023
  std::uint32_t seed = 0;  // of all random choices: another seed is an independent experiment
  // On a board of three irradiance words (BoardInfo::irradiance_words): factors of each light's power for red, green
  // and blue, not all 0. Empty: all lights are white. One pass then spreads the three colours, with
  // Material::scattering_colour.
  std::vector<Colour> light_colours{};
  friend bool operator==(const Illumination&, const Illumination&) = default;
};

// Energies of one colour of light, as in LightingReport.
struct LightEnergy {
  double emitted = 0;
  double deposited = 0;
  double escaped = 0;
  double scattered_away = 0;
  double given_up = 0;
  double clipped = 0;
};

// The energy balance, in units of the lights' power (`unit` of it is one unit of the energy words). Exactly:
// emitted = deposited + escaped + scattered_away + clipped. With three irradiance words these are sums over red, green
// and blue.
struct LightingReport {
  std::uint64_t rays = 0;
  // The energy of the rays: the light that meets the volume, not the lights' whole power unless they are inside. For
  // point and distant lights that is exact, except for the rounding of each ray to whole units. Rays of a rectangle or
  // a sphere begin at random points of it, so there it is an estimate, which another seed changes and more rays
  // improve.
  double emitted = 0;
  double deposited = 0;  // into irradiance words
  double escaped = 0;    // out of the volume
  // The escaped energy by face: x = 0, x = size - 1, y = 0, y = size - 1, z = 0, z = size - 1; the six sum to
  // `escaped`. For a slab that is lit along z, the last two are its reflectance and its transmittance. At an edge or a
  // corner, the face whose plane the ray crosses first counts; if it crosses several at once, the one of the first
  // axis. Zero from boards of version 0.1.
  std::array<double, 6> escaped_by_face{};
  double scattered_away = 0;  // dropped by the printed rules, with rays given up, and by routines
  double given_up = 0;        // of that, with rays at the end of their lifetime
  double clipped = 0;         // did not fit saturated irradiance words
  double unit = 0;
  std::vector<std::string> warnings;  // a light in a solid, much energy clipped, low albedo where scattering matters
  // With three irradiance words: of red, green and blue, which sum to the above; else empty.
  std::vector<LightEnergy> colours{};
};

// Error bar of a kHigh pass: the standard error of `irradiance`, one voxel's or the sum over many, in the lights' unit.
// Photons are absorbed whole, so it falls with the root of rays_per_face_voxel. For a single voxel it is an upper
// bound, because a photon's energy is split between eight voxels.
// With three irradiance words: of the sum of red, green and blue.
inline double standard_error(const LightingReport& report, double irradiance) {
  return report.rays == 0 ? 0 : std::sqrt(irradiance * report.emitted / static_cast<double>(report.rays));
}

}  // namespace gicube
