// Geometric factors without sampling, against closed forms.
#include "form_factors/exchange/box_factor.h"

#include "test.h"

namespace gicube::samples {
namespace {

constexpr double kPi = std::numbers::pi;
double mean_factor(const AxisBox& a, const AxisBox& b, double kappa = 0) { return WayFactor(a, b).at(kappa); }
AxisBox cube(double x, double y, double z) { return {{x, y, z}, {x + 1, y + 1, z + 1}, kMedium}; }
const AxisBox kFloor{{0, 0, 0}, {1, 1, 0}, 5};

TEST(BoxFactor, ParallelSquaresASideApart) {
  EXPECT_NEAR(mean_factor(kFloor, {{0, 0, 1}, {1, 1, 1}, 4}), 0.199825, 1e-5);
}

TEST(BoxFactor, SquaresWithACommonEdge) { EXPECT_NEAR(mean_factor(kFloor, {{0, 0, 0}, {0, 1, 1}, 1}), 0.200044, 1e-5); }

TEST(BoxFactor, TheSidesOfARoomSumToOne) {
  double sum = mean_factor(kFloor, {{0, 0, 1}, {1, 1, 1}, 4});
  sum += mean_factor(kFloor, {{0, 0, 0}, {0, 1, 1}, 1});
  sum += mean_factor(kFloor, {{1, 0, 0}, {1, 1, 1}, 0});
  sum += mean_factor(kFloor, {{0, 0, 0}, {1, 0, 1}, 3});
  sum += mean_factor(kFloor, {{0, 1, 0}, {1, 1, 1}, 2});
  EXPECT_NEAR(sum, 1, 5e-5);
}

// Means of 1/r^2 of unit cubes (shared design's table, within 0.1%): they share a face, an edge, a corner; are two
// apart.
TEST(BoxFactor, CubesThatTouch) {
  EXPECT_NEAR(kPi * mean_factor(cube(0, 0, 0), cube(1, 0, 0)), 1.1953, 2e-4);
  EXPECT_NEAR(kPi * mean_factor(cube(0, 0, 0), cube(1, 1, 0)), 0.563, 5e-4);
  EXPECT_NEAR(kPi * mean_factor(cube(0, 0, 0), cube(1, 1, 1)), 0.360, 5e-4);
  EXPECT_NEAR(kPi * mean_factor(cube(0, 0, 0), cube(2, 0, 0)), 0.260, 5e-4);
}

TEST(BoxFactor, ACubeWithItselfIsTheSumOfItsEighths) {
  double sum = 0;
  for (int i = 0; i < 64; ++i) {
    const auto eighth = [](int part) {
      AxisBox box;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = 0.5 * (part >> axis & 1);
        box.high[axis] = box.low[axis] + 0.5;
      }
      return box;
    };
    sum += mean_factor(eighth(i % 8), eighth(i / 8)) / 64;
  }
  EXPECT_NEAR(mean_factor(cube(0, 0, 0), cube(0, 0, 0)), sum, 1e-5 * sum);
}

// In a medium of kappa a side (shared design's table, within its rounding).
TEST(BoxFactor, SquaresInAMedium) {
  const AxisBox ceiling{{0, 0, 1}, {1, 1, 1}, 4}, wall{{0, 0, 0}, {0, 1, 1}, 1};
  EXPECT_NEAR(mean_factor(kFloor, ceiling, 0.1), 0.1789, 1e-4);
  EXPECT_NEAR(mean_factor(kFloor, ceiling, 1), 0.0662, 1e-4);
  EXPECT_NEAR(mean_factor(kFloor, ceiling, 3), 0.0074, 1e-4);
  EXPECT_NEAR(mean_factor(kFloor, wall, 0.1), 0.190, 1e-3);
  EXPECT_NEAR(mean_factor(kFloor, wall, 1), 0.122, 5e-4);
  EXPECT_NEAR(mean_factor(kFloor, wall, 3), 0.061, 5e-4);
}

TEST(BoxFactor, FacesThatLookAwayOrLieInOnePlaneSeeNothing) {
  EXPECT_EQ(mean_factor(kFloor, {{0, 0, 1}, {1, 1, 1}, 5}), 0);
  EXPECT_EQ(mean_factor(kFloor, {{0, 0, -1}, {1, 1, -1}, 4}), 0);
  EXPECT_EQ(mean_factor(kFloor, kFloor), 0);
  EXPECT_EQ(mean_factor(kFloor, {{0, 0, 0}, {1, 1, 0}, 4}), 0);
}

TEST(BoxFactor, FarAwayItIsThatOfTwoPoints) {
  EXPECT_NEAR(mean_factor(cube(0, 0, 0), cube(100, 0, 0)) * kPi * 1e4, 1, 1e-3);
  EXPECT_NEAR(mean_factor(kFloor, {{0, 0, 100}, {1, 1, 100}, 4}) * kPi * 1e4, 1, 1e-3);
}

TEST(BoxFactor, IsTheSameBothWays) {
  const AxisBox wall{{3, 0, 0}, {3, 2, 1}, 0};
  EXPECT_NEAR(mean_factor(kFloor, wall), mean_factor(wall, kFloor), 1e-12);
  EXPECT_GT(mean_factor(kFloor, wall), 0);
}

}  // namespace
}  // namespace gicube::samples
