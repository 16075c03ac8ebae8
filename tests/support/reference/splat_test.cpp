#include "splat.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace gicube::reference {
namespace {

constexpr Dims kDims{4, 3, 5};

TEST(Splat, KeepsTheEnergyAndItsCentre) {
  Splat splat(kDims);
  splat.add({1.25, 0.5, 3.875}, 2);
  EXPECT_DOUBLE_EQ(splat.sum(), 2);
  Vec3 centre;
  for (int z = 0; z < kDims[2]; ++z) {
    for (int y = 0; y < kDims[1]; ++y) {
      for (int x = 0; x < kDims[0]; ++x)
        centre = centre +
                 splat.at(x, y, z) / 2 * Vec3{static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)};
    }
  }
  EXPECT_NEAR(length(centre - Vec3{1.25, 0.5, 3.875}), 0, 1e-12);
  EXPECT_DOUBLE_EQ(splat.at(1, 0, 3), 2 * 0.75 * 0.5 * 0.125);
  EXPECT_DOUBLE_EQ(splat.at(2, 1, 4), 2 * 0.25 * 0.5 * 0.875);
}

TEST(Splat, GivesAVoxelAllThatFallsOnIt) {
  Splat splat(kDims);
  splat.add({3, 2, 4}, 1);
  splat.add({0, 0, 0}, 3);
  EXPECT_EQ(splat.at(3, 2, 4), 1);
  EXPECT_EQ(splat.at(0, 0, 0), 3);
}

TEST(Splat, RefusesPlacesOutside) {
  Splat splat(kDims);
  EXPECT_THROW(splat.add({3.01, 0, 0}, 1), std::out_of_range);
  EXPECT_THROW(splat.add({0, -0.01, 0}, 1), std::out_of_range);
}

}  // namespace
}  // namespace gicube::reference
