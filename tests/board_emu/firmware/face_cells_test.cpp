// What a light sees of the volume's faces, against closed forms.
#include "firmware/face_cells.h"

#include "test.h"

namespace gicube::emu {
namespace {

using std::numbers::pi;

TEST(SolidAngle, IsTheClosedFormOfACentredRectangle) {
  // 4 asin of the product of the half angles' sines.
  for (const double half : {0.5, 1.0, 3.0, 100.0}) {
    const double expected = 4 * std::asin(half / std::hypot(half, 2) * 1.5 * half / std::hypot(1.5 * half, 2));
    EXPECT_NEAR(solid_angle({{-half, -1.5 * half}, {half, 1.5 * half}, 2}), expected, 1e-12) << half;
  }
}

TEST(SolidAngle, IsRightFarAwayNearAndGrazing) {
  EXPECT_NEAR(solid_angle({{1e6, 0}, {1e6 + 1, 1}, 1e6}) * 1e12, std::sqrt(0.125), 1e-6);
  EXPECT_NEAR(solid_angle({{-0.5, -0.5}, {0.5, 0.5}, 1e-9}), 2 * pi, 1e-6);
  EXPECT_NEAR(solid_angle({{0, 0}, {1, 1}, 1e-9}), pi / 2, 1e-7);  // straight over a corner
  EXPECT_NEAR(solid_angle({{5, 5}, {6, 6}, 1e-6}), 0, 1e-7);
}

TEST(SolidAngle, OfTheFacesOfABoxAddsUpToTheSphere) {
  const Vector light{0.3, 4.9, 2.2}, box{5, 5, 3};
  double whole = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (const double height : {light[axis], box[axis] - light[axis]})
      whole += solid_angle({{-light[b], -light[c]}, {box[b] - light[b], box[c] - light[c]}, height});
  }
  EXPECT_NEAR(whole, 4 * pi, 1e-12);
}

// The share of the points made from (s, t) on a grid that lie in part of the rectangle is that part's solid angle.
TEST(PointSeen, IsUniformInSolidAngle) {
  for (const SeenRectangle seen : {SeenRectangle{{-0.5, -0.5}, {0.5, 0.5}, 0.1},
                                   {{0.2, 1}, {1.2, 3}, 0.4},
                                   {{-3, 2}, {-2, 2.5}, 2},
                                   {{-0.9, -0.1}, {0.1, 0.9}, 1e-3}}) {
    SeenRectangle part = seen;
    part.high = {seen.low[0] + 0.4 * (seen.high[0] - seen.low[0]), seen.low[1] + 0.7 * (seen.high[1] - seen.low[1])};
    constexpr int kGrid = 400;
    int within = 0;
    for (int i = 0; i < kGrid * kGrid; ++i) {
      const auto p = point_seen(seen, (i % kGrid + 0.5) / kGrid, (i / kGrid + 0.5) / kGrid);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        ASSERT_GE(p[axis], seen.low[axis]);
        ASSERT_LE(p[axis], seen.high[axis]);
      }
      if (p[0] < part.high[0] && p[1] < part.high[1]) ++within;
    }
    EXPECT_NEAR(static_cast<double>(within) / (kGrid * kGrid), solid_angle(part) / solid_angle(seen), 0.004)
        << seen.height;
  }
}

TEST(PointSeen, StaysOnTheRectangleWhereArithmeticFails) {
  for (const SeenRectangle seen : {SeenRectangle{{-0.5, -0.5}, {0.5, 0.5}, 1e-9},
                                   {{0, 0}, {1, 1}, 1e-9},
                                   {{2, 2}, {3, 3}, 1e-9},
                                   {{1e6, 0}, {1e6 + 1, 1}, 3}}) {
    for (int i = 0; i < 121; ++i) {
      const auto p = point_seen(seen, i % 11 / 10.0, i / 11 / 10.0);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        EXPECT_GE(p[axis], seen.low[axis]);
        EXPECT_LE(p[axis], seen.high[axis]);
      }
    }
  }
}

TEST(FaceCells, AreAllCellsOfSixFacesOnceRowByRow) {
  const FaceCells cells({4 * wire::kVoxel, 2 * wire::kVoxel, 3 * wire::kVoxel});
  EXPECT_EQ(cells.count(), 2u * (2 * 3 + 3 * 4 + 4 * 2));
  std::set<std::array<std::uint32_t, 4>> seen;
  for (std::uint64_t i = 0; i < cells.count(); ++i) {
    const FaceCell cell = cells.cell(i);
    ASSERT_LT(cell.at[0], cells.extent((cell.axis + 1) % 3));
    ASSERT_LT(cell.at[1], cells.extent((cell.axis + 2) % 3));
    seen.insert({static_cast<std::uint32_t>(cell.axis), cell.far, cell.at[0], cell.at[1]});
  }
  EXPECT_EQ(seen.size(), cells.count());
}

}  // namespace
}  // namespace gicube::emu
