#include "camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gicube::reference {
namespace {

constexpr double kExact = 1e-12;
constexpr Vec3 kIsotropic{1, 1, 1};

void expect_near(Vec3 a, Vec3 b) { EXPECT_NEAR(length(a - b), 0, kExact); }

View looking_down() {
  View view;
  view.eye = {10, 20, 100};
  view.look_at = {10, 20, 0};
  view.width = 200;
  view.height = 100;
  view.fov_degrees = 60;
  return view;
}

TEST(PerspectiveCamera, SeesLookAtInTheMiddle) {
  View view = looking_down();
  view.look_at = {-30, 4, 7};
  const Line line = Camera(view, {1, 2, 3}).line(100, 50);
  expect_near(line.origin, view.eye);
  expect_near(line.direction, normalise(view.look_at - view.eye));
}

TEST(PerspectiveCamera, SpansItsVerticalAngleWithSquarePixels) {
  const Camera camera(looking_down(), kIsotropic);
  expect_near(camera.line(100, 0).direction, {0, std::sin(std::numbers::pi / 6), -std::cos(std::numbers::pi / 6)});
  expect_near(camera.line(100, 100).direction, {0, -std::sin(std::numbers::pi / 6), -std::cos(std::numbers::pi / 6)});
  expect_near(camera.line(200, 50).direction, normalise({2 * std::tan(std::numbers::pi / 6), 0, -1}));
}

TEST(OrthographicCamera, SpansItsHeightAndKeepsItsDirection) {
  View view = looking_down();
  view.orthographic_height = 50;
  const Camera camera(view, kIsotropic);
  expect_near(camera.line(0, 0).origin, {10 - 50, 20 + 25, 100});
  expect_near(camera.line(200, 100).origin, {10 + 50, 20 - 25, 100});
  expect_near(camera.line(0, 0).direction, {0, 0, -1});
}

TEST(Camera, HasItsRightAngleInPhysicalSpace) {
  // Spacing (1, 1, 2): seen along z, a pixel of one smallest edge is one voxel wide; seen along x, half a voxel in z.
  View view = looking_down();
  view.orthographic_height = 100;
  expect_near(Camera(view, {1, 1, 2}).line(101, 50).origin - view.eye, {1, 0, 0});
  view.eye = {-50, 20, 0};
  view.look_at = {0, 20, 0};
  expect_near(Camera(view, {1, 1, 2}).line(101, 50).origin - view.eye, {0, 0, 0.5});
}

TEST(Camera, PointsTowardsTheEyeInPhysicalSpace) {
  View view = looking_down();
  view.eye = {1, 0, 1};
  view.look_at = {0, 0, 0};
  expect_near(Camera(view, {1, 1, 3}).towards_eye(), normalise({1, 0, 3}));
}

TEST(Clip, KeepsWhatIsInTheBoxFromTheOriginOn) {
  const Dims dims{11, 11, 11};
  const auto through = clip({{5, 5, -2}, {0, 0, 1}}, dims, {});
  ASSERT_TRUE(through);
  EXPECT_NEAR(through->begin, 2, kExact);
  EXPECT_NEAR(through->end, 12, kExact);
  const auto from_inside = clip({{5, 5, 7}, {0, 0, -1}}, dims, {});
  ASSERT_TRUE(from_inside);
  EXPECT_EQ(from_inside->begin, 0);
  EXPECT_NEAR(from_inside->end, 7, kExact);
  EXPECT_FALSE(clip({{5, 5, 11}, {0, 0, 1}}, dims, {}));
  EXPECT_FALSE(clip({{5, 10.001, -2}, {0, 0, 1}}, dims, {}));
  EXPECT_TRUE(clip({{5, 10, -2}, {0, 0, 1}}, dims, {}));  // in a face
}

TEST(Clip, KeepsTheRightSideOfEveryPlane) {
  const CutPlane planes[] = {{{0, 0, 2}, 6}, {{0, 0, -1}, -8}};
  const auto kept = clip({{5, 5, -2}, {0, 0, 1}}, {11, 11, 11}, planes);
  ASSERT_TRUE(kept);
  EXPECT_NEAR(kept->begin, 5, kExact);
  EXPECT_NEAR(kept->end, 10, kExact);
}

}  // namespace
}  // namespace gicube::reference
