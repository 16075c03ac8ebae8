#include "point_source.h"

#include <gtest/gtest.h>

#include <cmath>

#include "photons.h"
#include "splat.h"

namespace gicube::reference {
namespace {

constexpr Vec3 kLow{-100, -100, -100}, kHigh{100, 100, 100};

double sum_round(double kappa, Vec3 source, int reach) {
  double sum = 0;
  for (int z = -reach; z <= reach; ++z) {
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x)
        sum += absorbed_by_voxel(kappa, source,
                                 {static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)}, kLow, kHigh);
    }
  }
  return sum;
}

TEST(PointSource, LeavesAllItsEnergyInItsSurroundings) {
  // At most e^-12 passes six voxels.
  EXPECT_NEAR(sum_round(2, {0, 0, 0}, 6), 1, 1e-4);
  EXPECT_NEAR(sum_round(2, {0.3, -0.2, 0.5}, 6), 1, 1e-4);
}

TEST(PointSource, IsItsDensityFarAway) {
  const double far = absorbed_by_voxel(0.1, {0, 0, 0}, {20, 15, 0}, kLow, kHigh);
  EXPECT_NEAR(far / absorbed_density(0.1, 25), 1, 2e-3);
}

TEST(PointSource, IsCutWithTheMedium) {
  const double whole = absorbed_by_voxel(0.5, {0, 0, 0}, {3, 0, 0}, kLow, kHigh);
  EXPECT_NEAR(absorbed_by_voxel(0.5, {0, 0, 0}, {3, 0, 0}, {-100, 0, -100}, kHigh), whole / 2, 1e-9);
}

TEST(PointSource, LeavesWhatPhotonsLeave) {
  constexpr double kKappa = 0.4;
  constexpr int kPhotons = 400'000;
  const Vec3 source{4.25, 4, 3.5}, last{8, 8, 8};
  Splat splat({9, 9, 9});
  follow(
      {{0, 0, 0}, last, kKappa, 0}, kPhotons, 3,
      [&](Random& random) {
        return Photon{source, random.direction()};
      },
      [&](Vec3 position, double weight) { splat.add(position, weight); });
  for (const Vec3 voxel : {Vec3{4, 4, 3}, {5, 4, 4}, {4, 6, 2}, {7, 7, 7}, {0, 4, 4}, {8, 8, 8}}) {
    const double expected = absorbed_by_voxel(kKappa, source, voxel, {0, 0, 0}, last);
    const double measured =
        splat.at(static_cast<int>(voxel.x), static_cast<int>(voxel.y), static_cast<int>(voxel.z)) / kPhotons;
    // Each photon gives a voxel at most 1: the variance is below the mean.
    EXPECT_NEAR(measured, expected, 4 * std::sqrt(expected / kPhotons)) << voxel.x << " " << voxel.y << " " << voxel.z;
  }
}

}  // namespace
}  // namespace gicube::reference
