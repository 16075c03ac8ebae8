// A sphere's outline: camera, clipping and march together.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "march.h"
#include "test_scene.h"

namespace gicube::reference {
namespace {

constexpr double kRadius = 20;  // smallest voxel edges

// An opaque ball in the middle, its surface where the value is 1/2. `spacing` relative: the ball is round in physical
// space.
class BallScene : public TestScene {
 public:
  explicit BallScene(Dims dims = {49, 49, 49}, Vec3 spacing = {1, 1, 1})
      : TestScene(dims, [&](Vec3 p) {
          const Vec3 middle{(dims[0] - 1) / 2.0, (dims[1] - 1) / 2.0, (dims[2] - 1) / 2.0};
          const Vec3 d = p - middle;
          return std::clamp(0.5 + (kRadius - length({d.x * spacing.x, d.y * spacing.y, d.z * spacing.z})) / 20, 0.0,
                            1.0);
        }) {
    surface(0.5);
    scene.volume.spacing = spacing;
    scene.view.look_at = {(dims[0] - 1) / 2.0, (dims[1] - 1) / 2.0, (dims[2] - 1) / 2.0};
    scene.view.width = scene.view.height = 128;
    scene.view.step = 1.0 / 16;
  }
};

// The radius of a disc with the area of all opaque pixels.
double radius_pixels(const Picture& picture) {
  double area = 0;
  for (const Rgba& pixel : picture.pixels) area += pixel.opacity;
  return std::sqrt(area / std::numbers::pi);
}

TEST(Ball, HasItsOwnRadiusUnderParallelRays) {
  BallScene test;
  test.scene.view.orthographic_height = 64;  // two pixels a voxel
  test.scene.view.eye = {-40, 80, -10};
  EXPECT_NEAR(radius_pixels(render(test.scene)), 2 * kRadius, 0.15);
}

TEST(Ball, HasTheRadiusOfItsTangentConeInPerspective) {
  BallScene test;
  test.scene.view.eye = test.scene.view.look_at + 60 * normalise({1, 2, -2});
  test.scene.view.fov_degrees = 50;
  const double pixel = 2 * std::tan(25 * std::numbers::pi / 180) / 128;
  EXPECT_NEAR(radius_pixels(render(test.scene)), std::tan(std::asin(kRadius / 60)) / pixel, 0.15);
}

TEST(Ball, StaysRoundWhenItsVoxelsAreNot) {
  BallScene test({49, 49, 25}, {1, 1, 2});
  test.scene.view.eye = {-40, 24, 12};
  test.scene.view.orthographic_height = 64;
  const Picture picture = render(test.scene);
  EXPECT_NEAR(radius_pixels(picture), 2 * kRadius, 0.3);
  int across = 0, down = 0;
  for (int i = 0; i < 128; ++i) {
    across += picture.at(i, 64).opacity > 0.5;
    down += picture.at(64, i).opacity > 0.5;
  }
  EXPECT_NEAR(across, 4 * kRadius, 2);
  EXPECT_NEAR(down, 4 * kRadius, 2);
}

TEST(Picture, HasUpAtItsTopAndForwardCrossUpAtItsRight) {
  // Opaque where x and y are large; the eye looks along -z.
  TestScene test({17, 17, 17}, [](Vec3 p) { return p.x > 10 && p.y > 10 ? 1 : 0; });
  test.surface(0.5);
  test.scene.view.eye = {8, 8, 60};
  test.scene.view.look_at = {8, 8, 0};
  test.scene.view.orthographic_height = 16;
  test.scene.view.width = test.scene.view.height = 16;
  const Picture picture = render(test.scene);
  EXPECT_EQ(picture.at(14, 1).opacity, 1);
  EXPECT_EQ(picture.at(1, 1).opacity, 0);
  EXPECT_EQ(picture.at(14, 14).opacity, 0);
}

}  // namespace
}  // namespace gicube::reference
