// Hypertextures (K. Perlin and E. Hoffert, "Hypertexture", SIGGRAPH 1989): a solid's surface becomes a soft region, in
// which noise shapes the density. It is evaluated at a world's voxels each time that the world is built.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "gicube/export.h"
#include "gicube/scene/shape.h"

namespace gicube::scene {

enum class HypertextureKind {
  kNoise,       // the surface is moved in and out by noise
  kTurbulence,  // outwards, by the sum of the octaves' absolute values: clouds, fire balls
  kFur,         // hairs stand on it, as long as the noise at their roots is large
  kFlame,       // drawn out along +z above z = 0, torn the more the higher, and rising with time
};

// Lengths in units of the node that holds it. What a kind has no use for is ignored.
struct Hypertexture {
  HypertextureKind kind = HypertextureKind::kNoise;
  Shape shape = SphereShape{};
  double softness = 0.2;  // > 0: width of the ramp from density 0 to 1, with the surface in its middle
  double frequency = 3;   // > 0: cells of the (first octave's) noise a unit of length
  int octaves = 4;        // 1..12, each with twice the frequency and half the amplitude; kTurbulence, kFlame
  // >= 0: distance by which the (first octave's) noise moves the surface; kFlame: at the height 1 before stretching.
  double amplitude = 0.3;
  double time = 0;         // the noise changes altogether in about one unit; flames rise a cell of it
  double length = 0.3;     // > 0: of the longest hairs; kFur
  double curl = 0;         // >= 0: how far their tips are moved sideways; kFur
  double stretch = 3;      // > 0: how many times as tall the shape gets; kFlame
  std::uint32_t seed = 0;  // of the noise

  friend bool operator==(const Hypertexture&, const Hypertexture&) = default;
};

// "noise", "turbulence", "fur" or "flame". Throws InputError.
GICUBE_API HypertextureKind hypertexture_named(const std::string& name);

// Throws InputError with the name of the field ("softness: expected ..."). Does not open a mesh's file.
GICUBE_API void check(const Hypertexture& texture);

// The density at a point of the node's space, more than 0 to 1, or -1 where there is nothing. May be called on several
// threads. Throws as check() and fields_of() do.
GICUBE_API std::function<double(Vec3)> density_of(const Hypertexture& texture);

}  // namespace gicube::scene
