#include "gicube/scene/affine.h"

#include "test.h"

namespace gicube::scene {
namespace {

void expect_near(Vec3 a, Vec3 b, double tolerance = 1e-12) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Affine, TurnsCounterClockwiseAsSeenAgainstTheAxis) {
  expect_near(rotation({0, 0, 1}, 90).point({1, 0, 0}), {0, 1, 0});
  expect_near(rotation({2, 0, 0}, 90).point({0, 1, 0}), {0, 0, 1});
  expect_near(rotation({1, 1, 1}, 120).point({1, 2, 3}), {3, 1, 2});
}

TEST(Affine, ComposesFromTheInnerToTheOuter) {
  const Affine map = compose(translation({10, 0, 0}), compose(rotation({0, 0, 1}, 90), scaling({2, 1, 1})));
  expect_near(map.point({1, 0, 0}), {10, 2, 0});
}

TEST(Affine, IsUndoneByItsInverse) {
  const Affine map = compose(compose(translation({1, -2, 3}), rotation({1, 2, -1}, 33)), scaling({2, 0.5, -3}));
  EXPECT_NEAR(determinant(map), -3, 1e-12);
  expect_near(inverse(map).point(map.point({4, 5, 6})), {4, 5, 6});
  expect_near(map.point(inverse(map).point({4, 5, 6})), {4, 5, 6});
}

TEST(Affine, KnowsTheLeastGrowthOfAllDirections) {
  EXPECT_NEAR(min_stretch(scaling({3, 0.25, 7})), 0.25, 1e-12);
  EXPECT_NEAR(min_stretch(rotation({1, 2, 3}, 40)), 1, 1e-12);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 20; ++i) {
    Affine map;
    for (Vec3& row : map.rows) row = {normal(random), normal(random), normal(random)};
    const double least = min_stretch(map);
    double seen = 1e9;
    for (int k = 0; k < 5000; ++k) {
      const Vec3 direction = normalise({normal(random), normal(random), normal(random)});
      seen = std::min(seen, length(map.vector(direction)));
    }
    EXPECT_LE(least, seen + 1e-9);
    EXPECT_NEAR(least, seen, 0.1);
  }
}

}  // namespace
}  // namespace gicube::scene
