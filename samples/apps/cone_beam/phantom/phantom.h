// Phantoms of ellipsoids, which have line integrals in closed form; a detector's counting noise; and the error of a
// reconstruction.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cone_beam/geometry.h"

namespace gicube::samples {

struct Ellipsoid {
  double value = 0;    // added where ellipsoids overlap
  Vec3 axes{1, 1, 1};  // half lengths
  Vec3 centre;
  double turned = 0;  // about z, radians
};

using Phantom = std::vector<Ellipsoid>;

// The head of Shepp and Logan in three dimensions; half axes in units of `radius`, the head being 0.69 x 0.92 x 0.9.
// Densities of Kak and Slaney, Principles of Computerized Tomographic Imaging (1988), table 3.1: a skull of 2, 1%
// contrasts in 1.02.
Phantom shepp_logan(double radius);
// These ellipsoids with the contrasts of Yu, Ye and Wang (2005): 1 for the skull, 0.1 to 0.2 inside.
Phantom high_contrast_shepp_logan(double radius);
Phantom uniform_sphere(double radius, double value);
// Seven flat discs of value 1 along the axis of rotation, radius / 9 thick and 11/36 of `radius` apart. A wide
// cone smears them into one another (after Defrise).
Phantom discs(double radius);

double value_at(const Phantom& phantom, Vec3 place);
// Along the straight line between two points outside the phantom.
double line_integral(const Phantom& phantom, Vec3 from, Vec3 to);

// Line integrals through the middles of all pixels.
Projections project(const Phantom& phantom, const ConeGeometry& geometry);
// At the voxels' centres, x fastest.
std::vector<float> voxels(const Phantom& phantom, const Grid& grid);

// Adds the noise of `photons` (> 0) per pixel: a line integral p becomes -ln(N / photons), with N from Poisson's
// distribution of mean photons e^-p. Its deviation is about e^(p/2) / sqrt(photons). A pixel without photons counts as
// half a photon; returns the number of such pixels. The noise depends on the seed and the view, not on the number of
// threads. Throws BadArgument (photons).
std::size_t add_poisson_noise(Projections& projections, double photons, std::uint64_t seed);

// Voxels to compare: their centres are within these distances of the axis of rotation and the middle plane, in
// Grid::spacing's unit.
struct FieldOfView {
  double radius = std::numeric_limits<double>::infinity();
  double half_height = std::numeric_limits<double>::infinity();
};

struct Comparison {
  std::size_t voxels = 0;
  double rmse = 0;
  double bias = 0;         // mean of values - truth
  double relative_l2 = 0;  // rmse over the root mean square of the truth
  double psnr = 0;         // dB: 20 log10 (greatest - least of the truth / rmse); infinite if they are equal
  // Mean structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004) in three dimensions. Windows are Gaussians of
  // 1.5 voxels, cut at the volume's faces; K is 0.01 and 0.03 of the truth's span.
  double ssim = 0;
};

// Both x fastest. Throws BadArgument (another number of values than voxels; a field of view without voxels).
Comparison compare(const Grid& grid, std::span<const float> values, std::span<const float> truth,
                   const FieldOfView& field = {});

// Values - truth per voxel.
std::vector<float> differences(std::span<const float> values, std::span<const float> truth);

// Values on the line along `axis` (0, 1, 2) through voxel `through`. Throws BadArgument.
std::vector<float> profile(const Grid& grid, std::span<const float> values, int axis, Dims through);

}  // namespace gicube::samples
