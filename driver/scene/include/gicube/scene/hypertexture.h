// Hypertextures (K. Perlin and E. Hoffert, "Hypertexture", SIGGRAPH 1989): a solid's surface becomes a soft region, in
// which noise shapes the density. It is evaluated at a world's voxels whenever the world is built.
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
  kFur,         // hairs, whose length grows with the noise at their roots
  kFlame,       // stretched along +z above z = 0, torn more with height, and rising with time
};

// Lengths are in units of the node. Fields that a kind does not use are ignored.
struct Hypertexture {
  HypertextureKind kind = HypertextureKind::kNoise;
  Shape shape = SphereShape{};
  double softness = 0.2;  // > 0: width of the ramp from density 0 to 1, with the surface in its middle
  double frequency = 3;   // > 0: cells of the (first octave's) noise per unit of length
  int octaves = 4;        // 1..12, each with twice the frequency and half the amplitude; kTurbulence, kFlame
  // >= 0: distance by which the (first octave's) noise moves the surface; kFlame: at the height 1 before stretching.
  double amplitude = 0.3;
  double time = 0;         // the noise changes completely in about one unit; flames rise by one cell per unit
  double length = 0.3;     // > 0: of the longest hairs; kFur
  double curl = 0;         // >= 0: distance by which their tips are moved sideways; kFur
  double stretch = 3;      // > 0: factor of the shape's height; kFlame
  std::uint32_t seed = 0;  // of the noise

  friend bool operator==(const Hypertexture&, const Hypertexture&) = default;
};

// "noise", "turbulence", "fur" or "flame". Throws InputError.
GICUBE_API HypertextureKind hypertexture_named(const std::string& name);

// Throws InputError with the name of the field ("softness: expected ..."). Does not open a mesh's file.
GICUBE_API void check(const Hypertexture& texture);

// The density at a point of the node's space: above 0 and up to 1, or -1 where there is nothing. May be called on
// several threads. Throws like check() and fields_of().
GICUBE_API std::function<double(Vec3)> density_of(const Hypertexture& texture);

}  // namespace gicube::scene
