#include "fdk_phantoms.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace gicube::reference {
namespace {

// One view along x from far away, so that pixels hold lengths along x.
FdkScan one_view(const Solid& solid, int pixels, double pitch) {
  FdkScan scan;
  scan.geometry.source_to_axis = 1e5;
  scan.geometry.source_to_detector = 1e5 + 50;
  scan.geometry.detector = {pixels, pixels, pitch, pitch};
  scan.geometry.angles = {0, 1};
  scan.object = {solid};
  return scan;
}

TEST(FdkPhantoms, RaysMeasureAnUprightBoxAndATurnedOne) {
  const auto middle = [](const FdkScan& scan) { return double{project(scan).view(0)[4]}; };
  EXPECT_NEAR(middle(one_view({Solid::Shape::kBox, 0.5, {6, 9, 9}, {}, 0}, 3, 1)), 0.5 * 12, 1e-3);
  EXPECT_NEAR(middle(one_view({Solid::Shape::kBox, 0.5, {6, 60, 9}, {}, 0.3}, 3, 1)), 0.5 * 12 / std::cos(0.3), 1e-3);
  EXPECT_NEAR(middle(one_view({Solid::Shape::kEllipsoid, 2, {7, 3, 2}, {40, 0, 0}, 0}, 3, 1)), 2 * 14, 1e-3);
  EXPECT_EQ(middle(one_view({Solid::Shape::kBox, 1, {6, 9, 9}, {0, 11, 0}, 0}, 3, 1)), 0);
}

TEST(FdkPhantoms, ProjectionsHoldTheVolumeOfSolids) {
  constexpr double kPitch = 0.25;
  const auto volume = [](const Solid& solid) {
    const auto views = project(one_view(solid, 160, kPitch));
    return kPitch * kPitch * std::accumulate(views.view(0), views.view(0) + views.view_size(), 0.0);
  };
  const double ellipsoid = 4.0 / 3 * std::acos(-1.0) * 9 * 6 * 5, box = 8 * 4 * 5 * 6;
  EXPECT_NEAR(volume({Solid::Shape::kEllipsoid, 1, {9, 6, 5}, {3, -2, 4}, 0.7}), ellipsoid, 2e-3 * ellipsoid);
  EXPECT_NEAR(volume({Solid::Shape::kBox, 1, {4, 5, 6}, {3, -2, 4}, 0.7}), box, 1e-2 * box);
}

TEST(FdkPhantoms, VoxelsHoldTheirVolumeToo) {
  FdkScan scan = one_view({Solid::Shape::kBox, 0.5, {4, 5, 6}, {3, -2, 4}, 0.7}, 2, 1);
  scan.geometry.volume = {{20, 24, 15}, {1.3, 1.1, 1.7}};
  const std::vector<double> means = mean_in_voxels(scan);
  const double sum = std::accumulate(means.begin(), means.end(), 0.0) * 1.3 * 1.1 * 1.7, box = 0.5 * 8 * 4 * 5 * 6;
  EXPECT_NEAR(sum, box, 2e-2 * box);
  EXPECT_EQ(*std::max_element(means.begin(), means.end()), 0.5);
}

TEST(FdkPhantoms, EveryViewSeesAllOfEachVolume) {
  for (const FdkScan& scan : fdk_scans(24)) {
    const auto& [to_axis, to_detector, detector, volume, angles, poses] = scan.geometry;
    for (const double angle : angles) {
      const double c = std::cos(angle), s = std::sin(angle);
      for (int corner = 0; corner < 8; ++corner) {
        const auto end = [&](int axis) {
          return (corner >> axis & 1) == 0 ? -0.5 : volume.dims[static_cast<std::size_t>(axis)] - 0.5;
        };
        const Vec3 at = samples::to_space(volume, {end(0), end(1), end(2)});
        const double magnified = to_detector / (to_axis - (at.x * c + at.y * s));
        const double u = magnified * (at.y * c - at.x * s), v = magnified * at.z;
        ASSERT_LE(std::abs(u - detector.offset_u), (detector.columns - 1) / 2.0 * detector.pitch_u) << scan.name;
        ASSERT_LE(std::abs(v - detector.offset_v), (detector.rows - 1) / 2.0 * detector.pitch_v) << scan.name;
      }
    }
  }
}

}  // namespace
}  // namespace gicube::reference
