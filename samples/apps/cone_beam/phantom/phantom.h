// Phantoms of ellipsoids, whose line integrals are known in closed form; counting noise of a detector; and how far a
// reconstruction is from what it should be.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
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
// Densities of Kak and Slaney, Principles of Computerized Tomographic Imaging (1988), table 3.1: a skull of 2, 1%
// contrasts in 1.02.
Phantom shepp_logan(double radius);
// These ellipsoids with the contrasts of Yu, Ye and Wang (2005): 1 for the skull, 0.1 to 0.2 inside.
Phantom high_contrast_shepp_logan(double radius);
Phantom uniform_sphere(double radius, double value);
// Seven flat discs of value 1 along the axis of rotation, an 18th part of `radius` half thick and 11 of 36 parts apart,
// which a wide cone smears into one another (after Defrise).
Phantom discs(double radius);

double value_at(const Phantom& phantom, Vec3 place);
// Along the whole straight line from one point to another, which lie outside of it.
double line_integral(const Phantom& phantom, Vec3 from, Vec3 to);

// Every pixel's line integral, through its middle.
Projections project(const Phantom& phantom, const ConeGeometry& geometry);
// At the voxels' centres, x fastest.
std::vector<float> voxels(const Phantom& phantom, const Grid& grid);

// Adds the noise of `photons` (> 0) per pixel: a line integral p becomes -ln(N / photons), with N from Poisson's
// distribution of mean photons e^-p. Its deviation is about e^(p/2) / sqrt(photons). A pixel that no photon reaches
// counts as half a one; returns the number of such pixels. The same seed makes the same noise, whatever the number of
// threads; views differ. Throws BadArgument (photons).
std::size_t add_poisson_noise(Projections& projections, double photons, std::uint64_t seed);

// The voxels that are compared: those whose centre is so near to the axis of rotation and to the middle plane, in
// Grid::spacing's unit.
struct FieldOfView {
  double radius = std::numeric_limits<double>::infinity();
  double half_height = std::numeric_limits<double>::infinity();
};

struct Comparison {
  std::size_t voxels = 0;
  double rmse = 0;
  double bias = 0;         // mean of values less truth
  double relative_l2 = 0;  // rmse over the root mean square of the truth
  double psnr = 0;         // dB: 20 log10 (greatest - least of the truth / rmse); infinite if they are equal
  // Structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004) in three dimensions: its mean over the voxels,
  // windows being Gaussians of 1.5 voxels, of which at a volume's face there is only a part; K 0.01 and 0.03 of the
  // truth's span.
  double ssim = 0;
};

// Both x fastest. Throws BadArgument (another number of values than voxels; a field of view without voxels).
Comparison compare(const Grid& grid, std::span<const float> values, std::span<const float> truth,
                   const FieldOfView& field = {});

// Values less truth, a voxel each.
std::vector<float> differences(std::span<const float> values, std::span<const float> truth);

// The values on the grid's line along `axis` (0, 1, 2) that runs through voxel `through`. Throws BadArgument.
std::vector<float> profile(const Grid& grid, std::span<const float> values, int axis, Dims through);

}  // namespace gicube::samples
