// Light in a homogeneous medium by plain Monte Carlo in double precision: what lighting rays are held against. Free
// paths are drawn from the exponential law, there are no steps and no voxels; scattering is isotropic, the boundary
// does not reflect.
#pragma once

#include <cstdint>
#include <functional>
#include <random>

#include "gicube/vector.h"

namespace gicube::reference {

class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }  // [0, 1)
  Vec3 direction();                                                          // uniform on the sphere
  Vec3 diffuse(Vec3 normal);                                                 // Lambert round a unit vector

 private:
  std::mt19937_64 bits_;
};

// A box of absorbing and scattering stuff; corners may lie at infinity.
struct Medium {
  Vec3 low, high;
  double extinction = 0;  // per length
  double albedo = 0;      // scattering over extinction
};

struct Photon {
  Vec3 position;   // in the box
  Vec3 direction;  // unit
};
using Emit = std::function<Photon(Random&)>;
// Called at each collision, before it; `weight` of the photon's energy is left.
using Collide = std::function<void(Vec3 position, double weight)>;

struct Estimate {
  double mean = 0;
  double error = 0;  // standard error
};

// Shares of the emitted energy; they add up to 1.
struct Fates {
  Estimate absorbed;
  Estimate back;          // left through the box's face of least z
  Estimate through;       // ... of greatest z
  Estimate sideways;      // ... another one
  double collisions = 0;  // mean of a photon: the sum of its weights before collisions
};

// A photon's weight falls by the albedo at each collision and it plays Russian roulette below 1/100.
Fates follow(const Medium& medium, std::uint64_t photons, std::uint64_t seed, const Emit& emit,
             const Collide& collide = {});

// Collimated light that falls along +z on a slab of infinite width, or on a half space if `thickness` is infinite.
Fates slab(double optical_thickness, double albedo, std::uint64_t photons, std::uint64_t seed);

}  // namespace gicube::reference
