// Hypertextures: octaves that are finer than the voxels which are to show them.
#include <algorithm>
#include <cmath>

#include "gicube/scene/hypertexture.h"
#include "gicube/scene/voxeliser.h"
#include "stability.h"

namespace gicube::stability {
namespace {

// Root of the mean square of what voxels miss of noise with so many voxels a cell: halfway between them, relative to
// the noise itself.
double missed(double voxels_a_cell) {
  const Dims dims{40, 40, 40};
  // Far within the ramp, so that the density is the noise.
  const scene::Hypertexture noise{.kind = scene::HypertextureKind::kNoise,
                                  .shape = scene::SphereShape{1e-9},
                                  .softness = 1000,
                                  .frequency = 1 / voxels_a_cell,
                                  .amplitude = 100};
  const auto density = scene::density_of(noise);
  const Vec3 away{0.37, 0.21, 0.11};  // from the noise's own zeroes
  const auto exact = [&](Vec3 p) { return density(p + away) + length(p + away) / noise.softness; };
  const scene::PlacedScan voxels = scene::place_density(dims, exact);
  double error = 0, size = 0;
  for (int i = 0; i < 39 * 39 * 39; ++i) {
    const Vec3 p{i % 39 + 0.5, i / 39 % 39 + 0.5, i / (39 * 39) + 0.5};
    error += std::pow(voxels.density(p) - exact(p), 2);
    size += std::pow(exact(p) - 0.5, 2);
  }
  return std::sqrt(error / size);
}

TEST(StabilityOfHypertextures, VoxelsLoseOctavesOfFewerThanTwoVoxelsACell) {
  const double fine = missed(1.3), two = missed(2), four = missed(4), eight = missed(8);
  record("missed_at_1_3_voxels_a_cell", fine);
  record("missed_at_2_voxels_a_cell", two);
  record("missed_at_4_voxels_a_cell", four);
  record("missed_at_8_voxels_a_cell", eight);
  EXPECT_GT(fine, 0.8);  // as much as there is
  EXPECT_LT(four, 0.3);
  EXPECT_LT(eight, four / 3);  // with the square of the voxels, at last
}

}  // namespace
}  // namespace gicube::stability
