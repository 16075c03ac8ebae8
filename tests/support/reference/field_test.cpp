#include "field.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test_scene.h"

namespace gicube::reference {
namespace {

constexpr double kExact = 1e-12;

void expect_near(Vec3 a, Vec3 b, double tolerance) { EXPECT_NEAR(length(a - b), 0, tolerance); }

TEST(Field, InterpolatesATrilinearFunctionExactly) {
  const auto f = [](Vec3 p) { return 0.25 + p.x / 32 - p.y * p.z / 64 + p.x * p.y * p.z / 256; };
  TestScene test({4, 4, 4}, f);
  const Field field(test.scene.volume, {});
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{3, 3, 3}, Vec3{1.25, 0.5, 2.875}, Vec3{2, 3, 1.5}}) {
    EXPECT_NEAR(field.sample(p).value, f(p), kExact);
    EXPECT_NEAR(field.sample(p).density, 4095 * f(p), 4095 * kExact);
  }
}

TEST(Field, HoldsValuesToTheRangeBeforeItInterpolates) {
  TestScene test({2, 2, 2}, [](Vec3 p) { return p.z == 0 ? -3 : 1; });
  const Field field(test.scene.volume, {});
  EXPECT_NEAR(field.sample({0, 0, 0.5}).value, 0.5, kExact);
}

TEST(Field, ReadsEverySampleTypeInItsOwnUnits) {
  const std::vector<std::int16_t> samples{-1000, -1000, -1000, -1000, 3000, 3000, 3000, 3000};
  VolumeView volume;
  volume.samples = std::as_bytes(std::span(samples));
  volume.dims = {2, 2, 2};
  volume.type = SampleType::kInt16;
  const Field field(volume, {});
  EXPECT_EQ(field.range(), (ValueRange{-1000, 3000}));
  EXPECT_NEAR(field.sample({0, 0, 0.25}).value, 0, 1e-9);

  volume.type = SampleType::kUint16;  // the same bits: 64536 and 3000
  EXPECT_EQ(Field(volume, {}).range(), (ValueRange{3000, 64536}));
  volume.type = SampleType::kUint8;
  EXPECT_EQ(Field(volume, {}).range(), (ValueRange{0, 255}));
  volume.type = SampleType::kUint12;
  EXPECT_EQ(Field(volume, {}).range(), (ValueRange{0, 4095}));
}

TEST(Field, GivesAConstantVolumeARangeOfOne) {
  UniformScene test({2, 2, 2});
  test.scene.volume.range.reset();
  EXPECT_EQ(Field(test.scene.volume, {}).range(), (ValueRange{0.5, 1.5}));
}

TEST(Gradient, OfALinearFieldPointsAlongItExactly) {
  const Vec3 slope{0.01, -0.02, 0.05};
  TestScene test({9, 9, 9}, [&](Vec3 p) { return 0.3 + dot(slope, p); });
  test.scene.volume.range = ValueRange{-10, 10};
  expect_near(Field(test.scene.volume, {}).gradient({3.3, 4.4, 5.5}), normalise(slope),
              1e-5);  // floats hold the volume
}

TEST(Gradient, IsPhysicalUnderAnisotropicSpacing) {
  const Vec3 slope{0.02, 0, 0.02};
  TestScene test({9, 9, 9}, [&](Vec3 p) { return 0.3 + dot(slope, p); });
  test.scene.volume.spacing = {0.5, 0.5, 1};
  expect_near(Field(test.scene.volume, {}).gradient({4, 4, 4}), normalise({2, 0, 1}), 1e-5);
}

TEST(Gradient, BelowAnEighthOfADensityUnitIsNone) {
  const auto gradient = [](double densities_a_voxel) {
    TestScene test({9, 9, 9}, [&](Vec3 p) { return densities_a_voxel * p.x / 4095; });
    return Field(test.scene.volume, {}).gradient({4, 4, 4});
  };
  expect_near(gradient(0.124), {0, 0, 0}, 0);
  expect_near(gradient(0.126), {1, 0, 0}, kExact);
}

TEST(Gradient, OfTheSobelFilterIsWeightedOneTwoOne) {
  // One bright voxel: at its neighbours along x and on the diagonals the filter gives its own weights.
  TestScene test({5, 5, 5}, [](Vec3 p) { return p == Vec3{2, 2, 2} ? 1 : 0; });
  const Field field(test.scene.volume, {});
  expect_near(field.voxel_gradient(1, 2, 2), {1, 0, 0}, kExact);
  expect_near(field.voxel_gradient(1, 1, 2), normalise({1, 1, 0}), kExact);
  expect_near(field.voxel_gradient(3, 1, 1), normalise({-1, 1, 1}), kExact);
  expect_near(field.voxel_gradient(2, 2, 2), {0, 0, 0}, 0);
  // Two: at (1, 2, 2) the nearer one counts 4 along x, the other one 2 along x and y.
  TestScene pair({5, 5, 5}, [](Vec3 p) { return p == Vec3{2, 2, 2} || p == Vec3{2, 3, 2} ? 1 : 0; });
  expect_near(Field(pair.scene.volume, {}).voxel_gradient(1, 2, 2), normalise({3, 1, 0}), kExact);
}

TEST(Gradient, SuppliedByTheCallerReplacesTheFilter) {
  UniformScene test({2, 2, 2});
  std::vector<float> gradients;
  for (int i = 0; i < 8; ++i) gradients.insert(gradients.end(), {0, 3, -4});
  test.scene.volume.gradients = gradients;
  expect_near(Field(test.scene.volume, {}).gradient({0.5, 0.5, 0.5}), {0, 0.6, -0.8}, kExact);
}

TEST(Gradient, IsInterpolatedFromUnitVectorsAndSoShorterBetweenTwoDirections) {
  UniformScene test({2, 2, 2});
  std::vector<float> gradients;
  for (int i = 0; i < 4; ++i) gradients.insert(gradients.end(), {5, 0, 0});
  for (int i = 0; i < 4; ++i) gradients.insert(gradients.end(), {0, 7, 0});
  test.scene.volume.gradients = gradients;
  expect_near(Field(test.scene.volume, {}).gradient({0.5, 0.5, 0.5}), {0.5, 0.5, 0}, kExact);
}

}  // namespace
}  // namespace gicube::reference
