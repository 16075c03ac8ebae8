// Phantoms of ellipsoids, whose line integrals are known in closed form, and counting noise of a detector.
#pragma once

#include <cstdint>
#include <vector>

#include "cone_beam/geometry.h"

namespace gicube::samples {

struct Ellipsoid {
  double value = 0;    // added to what it overlaps
  Vec3 axes{1, 1, 1};  // half lengths
  Vec3 centre;
  double turned = 0;  // about z, radians
};

using Phantom = std::vector<Ellipsoid>;

// The head of Shepp and Logan in three dimensions; half axes in units of `radius`, the head being 0.69 x 0.92 x 0.9.
// Densities of Kak and Slaney, Principles of Computerized Tomographic Imaging (1988), table 3.1: a skull of 2, 1% contrasts
// in 1.02.
Phantom shepp_logan(double radius);
// The same ellipsoids with the contrasts of Yu, Ye and Wang (2005): 1 for the skull, 0.1 to 0.2 inside.
Phantom high_contrast_shepp_logan(double radius);
Phantom uniform_sphere(double radius, double value);

double value_at(const Phantom& phantom, Vec3 place);
// Along the whole straight line from one point to another, which lie outside of it.
double line_integral(const Phantom& phantom, Vec3 from, Vec3 to);

// Every pixel's line integral, through its middle.
Projections project(const Phantom& phantom, const ConeGeometry& geometry);
// At the voxels' centres, x fastest.
std::vector<float> voxels(const Phantom& phantom, const Grid& grid);

// As if `photons` (> 0) left the source towards each pixel: a line integral p becomes -ln(N / photons), with N from Poisson's
// distribution of mean photons e^-p. Its deviation is about e^(p/2) / sqrt(photons). A pixel that no photon reaches counts
// as half a one; returned is how many such there are. The same seed makes the same noise, whatever the number of threads;
// views differ. Throws BadArgument (photons).
std::size_t add_poisson_noise(Projections& projections, double photons, std::uint64_t seed);

}  // namespace gicube::samples
