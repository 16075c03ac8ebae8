// Detectors that are displaced to widen the field, short scans, and what is neither.
#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "open_board.h"
#include "test.h"

namespace gicube::samples {
namespace {

using std::numbers::pi;

// The far side always reaches 100 at a detector of twice the magnification; the object has a radius of up to 44. 192
// columns if the detector is not displaced. All views see the end slices; 24 rows miss parts of them from 31 on, where
// the mean is 2.5% low.
ConeGeometry displaced_scan(double part, double side = 1) {
  constexpr double kReach = 100, kPitch = kReach / 96;
  const int columns = static_cast<int>(std::lround(kReach / (0.5 + part) / kPitch));
  return {.source_to_axis = 400,
          .source_to_detector = 800,
          .detector = {columns, 28, kPitch, 1.5 * kPitch, side * part * columns * kPitch},
          .volume = {{64, 64, 10}, {1.5, 1.5, 1.5}},
          .angles = even_angles(240, 0.1, 2 * pi)};
}

Reconstruction made(const ConeGeometry& geometry, const Phantom& phantom, const FdkSettings& settings = {}) {
  Board board = open_board();
  return reconstruct_fdk(board, geometry, project(phantom, geometry), settings);
}
double error(const ConeGeometry& geometry, const Phantom& phantom) {
  return compare(geometry.volume, made(geometry, phantom).values, voxels(phantom, geometry.volume), {44, 8}).rmse;
}

const Phantom kCylinder{{1, {40, 40, 1e5}, {}, 0}};

class Displaced : public testing::TestWithParam<double> {};

TEST_P(Displaced, AUniformCylindersMeanIsWithinAPercentAtEveryRadius) {
  for (const double side : {1.0, -1.0}) {
    const ConeGeometry geometry = displaced_scan(GetParam(), side);
    const Reconstruction found = made(geometry, kCylinder);
    std::vector<double> sums(38), counts(38);
    std::size_t i = 0;
    for (std::size_t z = 0; z < 10; ++z) {
      for_each_in_slice(geometry.volume, z, [&](Vec3 at) {
        const auto ring = static_cast<std::size_t>(std::hypot(at.x, at.y));
        const double value = double{found.values[i++]};
        if (ring >= sums.size()) return;
        sums[ring] += value;
        ++counts[ring];
      });
    }
    EXPECT_EQ(counts[0], 0);  // the four voxels about the axis are 1.06 from it
    for (std::size_t ring = 1; ring < sums.size(); ++ring) EXPECT_NEAR(sums[ring] / counts[ring], 1, 0.01) << ring;
  }
}

TEST_P(Displaced, IsAsGoodAsADetectorOfTheWholeWidthWithinATenth) {
  const ConeGeometry geometry = displaced_scan(GetParam()), whole = displaced_scan(0);
  // A cylinder, a head, and things off the axis.
  const Phantom off{
      {1, {40, 30, 1e5}, {3, -2, 0}, 0.4}, {0.5, {6, 6, 30}, {20, 5, 0}, 0}, {-0.5, {4, 4, 6}, {-15, 12, 2}, 0}};
  for (const Phantom& phantom : {kCylinder, high_contrast_shepp_logan(44), off}) {
    EXPECT_LT(error(geometry, phantom), 1.1 * error(whole, phantom));
  }
}

INSTANTIATE_TEST_SUITE_P(Offsets, Displaced, testing::Values(0.2, 0.3, 0.4, 0.45));

TEST(Displaced, IsNoneWhereTheNearSideSeesTheWholeObject) {
  const ConeGeometry geometry = displaced_scan(0.2);
  EXPECT_TRUE(is_displaced(geometry, project(kCylinder, geometry)));
  EXPECT_FALSE(is_displaced(geometry, project(uniform_sphere(15, 1), geometry)));
  ConeGeometry calibrated = displaced_scan(0);
  calibrated.detector.offset_u = 0.3 * calibrated.detector.pitch_u;
  EXPECT_FALSE(is_displaced(calibrated, project(kCylinder, calibrated)));
}

// 200 degrees, the axis seen 0.3 pixels beside the detector's middle: both halves of a cylinder are alike.
TEST(ShortScan, WithACalibratedOffsetHasTwoEqualHalves) {
  for (const double offset : {0.3, -0.3, 3.7}) {
    ConeGeometry geometry = displaced_scan(0);
    geometry.angles = even_angles(160, 0.4, 200 * pi / 180);
    geometry.detector.offset_u = offset * geometry.detector.pitch_u;
    const Reconstruction found = made(geometry, kCylinder);
    for (const double turn : {0.0, pi / 3, pi / 2, 2 * pi / 3}) {
      double right = 0, left = 0;
      std::size_t i = 0;
      for (std::size_t z = 0; z < 10; ++z) {
        for_each_in_slice(geometry.volume, z, [&](Vec3 at) {
          const double value = double{found.values[i++]}, across = at.x * std::cos(turn) + at.y * std::sin(turn);
          if (std::hypot(at.x, at.y) < 36) (across > 0 ? right : left) += value;
        });
      }
      EXPECT_NEAR(right / left, 1, 0.01) << offset << " " << turn;
    }
    EXPECT_NEAR(compare(geometry.volume, found.values, voxels(kCylinder, geometry.volume), {36, 8}).bias, 0, 0.01);
  }
}

// More than a turn, at angles that don't repeat: the second half of a turn is measured once more by half of the views.
TEST(OverScan, IsAsGoodAsATurn) {
  const Phantom head = high_contrast_shepp_logan(44);
  ConeGeometry turn = displaced_scan(0), more = turn;
  std::vector<double> angles;
  for (int i = 0; i < 280; ++i) angles.push_back(0.1 + i * 1.4 * pi / 180);  // 392 degrees
  more.angles = sorted_views(angles).angles;
  EXPECT_FALSE(is_short_scan(more));
  EXPECT_LT(error(more, head), 1.05 * error(turn, head));
}

TEST(Displaced, IsRefusedInAShortScanAndBesideTheAxis) {
  const auto saying = [](const char* text) { return ThrowsMessage<BadArgument>(HasSubstr(text)); };
  ConeGeometry geometry = displaced_scan(0.3);
  geometry.angles = even_angles(160, 0, 210 * pi / 180);
  EXPECT_THAT([&] { made(geometry, kCylinder); },
              saying("angles: expected a whole turn: the detector is displaced (offset_u 37.5) and the object reaches "
                     "beyond its near side"));
  EXPECT_NO_THROW(made(geometry, uniform_sphere(7, 1)));  // which the near side sees whole
  geometry = displaced_scan(0.3);
  geometry.detector.offset_u = 80;
  EXPECT_THAT([&] { made(geometry, kCylinder); },
              saying("detector.offset_u: expected within 61.9792 of 0, so that the ray"));
}

}  // namespace
}  // namespace gicube::samples
