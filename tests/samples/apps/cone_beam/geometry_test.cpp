#include "cone_beam/geometry.h"

#include "gicube/error.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

TEST(ConeGeometry, SpaceAndVoxelsAreEachOthersInverse) {
  const Grid grid{{10, 21, 32}, {0.5, 0.25, 2}};
  const Vec3 middle = to_space(grid, {4.5, 10, 15.5});
  EXPECT_EQ(middle, (Vec3{0, 0, 0}));
  const Vec3 there = to_space(grid, {1, 2, 3}), back = to_voxels(grid, there);
  EXPECT_DOUBLE_EQ(back.x, 1);
  EXPECT_DOUBLE_EQ(back.y, 2);
  EXPECT_DOUBLE_EQ(back.z, 3);
}

TEST(ConeGeometry, ADetectorsOffsetMovesItsPixels) {
  const Detector detector{5, 4, 2, 3, 7, -1};
  EXPECT_DOUBLE_EQ(u_of(detector, 2), 7);
  EXPECT_DOUBLE_EQ(u_of(detector, 4), 11);
  EXPECT_DOUBLE_EQ(v_of(detector, 0), -1 - 4.5);
}

TEST(ConeGeometry, AWholeTurnDoesNotMeasureItsFirstAngleTwice) {
  using std::numbers::pi;
  const auto whole = even_angles(4, 1, 2 * pi), half = even_angles(5, 0, pi);
  EXPECT_DOUBLE_EQ(whole.back(), 1 + 1.5 * pi);
  EXPECT_DOUBLE_EQ(half.back(), pi);
}

TEST(ConeGeometry, WhatIsWrongIsNamed) {
  const auto faulty = [](auto change) {
    ConeGeometry geometry = small_scan(16, 8);
    change(geometry);
    return [geometry] { check(geometry); };
  };
  EXPECT_NO_THROW(check(small_scan(16, 8)));
  EXPECT_THROWS(BadArgument,
                "projections: expected a view of the detector's size for each angle, got 3 x 2, 6 values",
                check(Projections{3, 2, std::vector<float>(6)}, small_scan(16, 8)));
  EXPECT_THAT(faulty([](auto& g) { g.source_to_axis = 0; }), ThrowsMessage<BadArgument>(HasSubstr("source_to_axis")));
  EXPECT_THAT(faulty([](auto& g) { g.source_to_axis = 50; }),
              ThrowsMessage<BadArgument>(HasSubstr("goes round the volume")));
  EXPECT_THAT(faulty([](auto& g) { g.detector.columns = 1; }),
              ThrowsMessage<BadArgument>(HasSubstr("detector.columns: expected at least 2, got 1")));
  EXPECT_THAT(faulty([](auto& g) { g.angles[3] = g.angles[2]; }), ThrowsMessage<BadArgument>(HasSubstr("angles[3]")));
  EXPECT_THAT(faulty([](auto& g) { g.angles.back() += 7; }), ThrowsMessage<BadArgument>(HasSubstr("angles[7]")));
  EXPECT_THAT(faulty([](auto& g) { g.volume.spacing.y = -1; }),
              ThrowsMessage<BadArgument>(HasSubstr("volume.spacing")));
}

}  // namespace
}  // namespace gicube::samples
