#include "march.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test_scene.h"

namespace gicube::reference {
namespace {

constexpr double kExact = 1e-12;
constexpr Vec3 kAlongZ{0, 0, 1};

// The opacity of a slab of `voxels` along z when its samples stand in the middles of their steps.
double opacity_through(TestScene& test, double step) {
  test.scene.view.step = step;
  return Renderer(test.scene).integrate({1.2, 1.7, step / 2}, kAlongZ).opacity;
}

TEST(Slab, TransmitsOneMinusAlphaToItsLengthForEveryStepThatDividesIt) {
  UniformScene test({4, 4, 17});
  test.look(0.1);
  for (const double step : {2.0, 1.0, 0.5, 0.25, 1.0 / 64}) {
    EXPECT_NEAR(1 - opacity_through(test, step), std::pow(0.9, 16), kExact) << "step " << step;
  }
}

TEST(Slab, OfExtinctionKappaTransmitsExpOfMinusTau) {
  UniformScene test({4, 4, 33});
  for (const double tau : {0.01, 1.0, 8.0}) {
    test.look(1 - std::exp(-tau / 32));
    EXPECT_NEAR(1 - opacity_through(test, 0.5), std::exp(-tau), kExact) << "tau " << tau;
  }
}

TEST(Slab, GathersItsColourTimesItsOpacity) {
  UniformScene test({4, 4, 17});
  const Colour colour{0.25, 0.5, 1};
  test.look(0.1, colour);
  const Rgba seen = Renderer(test.scene).integrate({1.2, 1.7, 0.25}, kAlongZ);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(seen.colour[c], colour[c] * seen.opacity, kExact);
}

TEST(Slab, SampledFromItsFaceHasOneSampleMoreThanSteps) {
  UniformScene test({4, 4, 17});
  test.look(0.1);
  test.scene.view.step = 0.1;  // kept to 16 bits: 0.1000061
  const Rgba seen = Renderer(test.scene).integrate({1, 1, -3}, kAlongZ);
  const double step = std::round(0.1 * 65536) / 65536;
  EXPECT_NEAR(1 - seen.opacity, std::pow(0.9, step * (std::floor(16 / step) + 1)), kExact);
}

TEST(Slab, SeenObliquelyHasTheSampledLengthOfTheRay) {
  UniformScene test({65, 65, 17});
  test.look(0.05);
  test.scene.view.step = 1.0 / 64;
  const Rgba seen = Renderer(test.scene).integrate({3, 3, -1}, {1, 2, 2});
  // 16 voxels in z are 24 along the ray; the sum is right to one step.
  EXPECT_NEAR(std::log(1 - seen.opacity) / std::log(0.95), 24, 1.0 / 64 + 1e-9);
}

TEST(Slab, OfTwiceTheSpacingHasTheOpacityOfTwiceTheLength) {
  UniformScene test({4, 4, 17});
  test.look(0.03);
  for (const Vec3 spacing : {Vec3{1, 1, 2}, Vec3{0.25, 0.25, 0.5}}) {
    test.scene.volume.spacing = spacing;
    EXPECT_NEAR(1 - opacity_through(test, 0.5), std::pow(0.97, 32), kExact);
  }
  test.scene.volume.spacing = {1, 2, 1};  // the ray does not run along y
  EXPECT_NEAR(1 - opacity_through(test, 0.5), std::pow(0.97, 16), kExact);
}

TEST(Slab, WithFullOpacityIsOpaqueAtOnceForEveryStep) {
  UniformScene test({4, 4, 17});
  test.look(1, {0.5, 0.5, 0.5});
  for (const double step : {1.0 / 64, 0.5, 4.0}) {
    test.scene.view.step = step;
    EXPECT_EQ(Renderer(test.scene).integrate({1, 1, 0}, kAlongZ), (Rgba{{0.5, 0.5, 0.5}, 1}));
  }
}

TEST(ExtinctionRamp, SumsToItsIntegralAndHalfAStepOfItsEnds) {
  // kappa(z) = z / 40 on 0..16, its opacities tabulated at every 1/16 voxel, where the samples fall.
  TestScene test({4, 4, 17}, [](Vec3 p) { return p.z / 16; });
  test.scene.functions[0].colours = {{0, {1, 1, 1}}};
  for (int i = 0; i <= 256; ++i) test.scene.functions[0].opacities.push_back({i / 256.0, 1 - std::exp(-i / 16.0 / 40)});
  const double tau = 16 * 16 / 2 / 40.0;
  for (const double step : {1.0, 0.5, 0.25, 0.125, 0.0625}) {
    test.scene.view.step = step;
    const double seen = -std::log(1 - Renderer(test.scene).integrate({1, 1, 0}, kAlongZ).opacity);
    EXPECT_NEAR(seen, tau + step / 2 * 16 / 40, 1e-9) << "step " << step;
  }
}

TEST(OpacityRamp, ConvergesWithTheSquareOfTheStepWhenSampledInTheMiddles) {
  // alpha(z) = c z: the integral of -ln(1 - c z) over 0..L is ((1 - u) ln(1 - u) + u) / c with u = c L.
  constexpr double kSlope = 0.05, kLength = 16, kEnd = kSlope * kLength;
  TestScene test({4, 4, 17}, [](Vec3 p) { return p.z / kLength; });
  test.scene.functions[0] = {{{0, {1, 1, 1}}}, {{0, 0}, {1, kEnd}}};
  const double tau = ((1 - kEnd) * std::log(1 - kEnd) + kEnd) / kSlope;
  const auto error = [&](double step) { return std::abs(-std::log(1 - opacity_through(test, step)) - tau); };
  EXPECT_LT(error(0.0625), 1e-3);
  EXPECT_NEAR(error(0.25) / error(0.125), 4, 0.1);
  EXPECT_NEAR(error(0.125) / error(0.0625), 4, 0.1);
}

TEST(Over, IsAssociativeWhereverAHomogeneousSegmentIsSplit) {
  UniformScene test({4, 4, 17});
  test.look(0.2, {0.9, 0.5, 0.1});
  const double step = test.scene.view.step = 0.5;
  const Rgba whole = Renderer(test.scene).integrate({1, 1, step / 2}, kAlongZ);
  for (const double split : {0.5, 4.0, 15.5}) {
    test.scene.view.cut_planes = {{{0, 0, -2}, -2 * split}};
    const Rgba front = Renderer(test.scene).integrate({1, 1, step / 2}, kAlongZ);
    test.scene.view.cut_planes.clear();
    const Rgba both = over(front, Renderer(test.scene).integrate({1, 1, split + step / 2}, kAlongZ));
    EXPECT_NEAR(both.opacity, whole.opacity, kExact);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(both.colour[c], whole.colour[c], kExact);
  }
}

TEST(CutPlane, RemovesWhatLiesOnItsWrongSide) {
  UniformScene test({4, 4, 33});
  test.look(0.1);
  test.scene.view.step = 1;
  test.scene.view.cut_planes = {{{0, 0, 3}, 3 * 15.5}};  // keeps 15.5..32: samples at 15.5, 16.5 .. 31.5
  EXPECT_NEAR(1 - Renderer(test.scene).integrate({1, 1, -9}, kAlongZ).opacity, std::pow(0.9, 17), kExact);
  test.scene.view.cut_planes = {{{0, 0, -1}, -15.5}};  // keeps 0..15.5: samples at 0 .. 15
  EXPECT_NEAR(1 - Renderer(test.scene).integrate({1, 1, -9}, kAlongZ).opacity, std::pow(0.9, 16), kExact);
  test.scene.view.cut_planes = {{{0, 0, -1}, 1}};  // keeps z <= -1: nothing
  EXPECT_EQ(Renderer(test.scene).integrate({1, 1, -9}, kAlongZ), Rgba{});
}

TEST(Ray, ThatMissesTheVolumeGathersNothing) {
  UniformScene test({4, 4, 4});
  test.look(1);
  EXPECT_EQ(Renderer(test.scene).integrate({5, 1, -9}, kAlongZ), Rgba{});
  EXPECT_EQ(Renderer(test.scene).integrate({1, 1, 9}, kAlongZ), Rgba{});
}

TEST(Ray, EndsWithTheSampleThatReachesTheThreshold) {
  UniformScene test({4, 4, 33});
  test.look(0.5);
  test.scene.view.step = 1;
  test.scene.view.opacity_threshold = 0.8;
  EXPECT_NEAR(Renderer(test.scene).integrate({1, 1, 0}, kAlongZ).opacity, 1 - std::pow(0.5, 3), kExact);
}

TEST(Ray, TakesTheTransferFunctionOfTheNearestVoxelsTag) {
  UniformScene test({2, 2, 9});
  std::vector<std::uint8_t> tags(2 * 2 * 9, 0);
  for (std::size_t i = 2 * 2 * 5; i < tags.size(); ++i) tags[i] = 3;  // from z = 4.5 on
  test.scene.volume.tags = tags;
  test.look(0.1, {1, 0, 0});
  test.scene.functions[3] = {{{0, {0, 1, 0}}}, {{0, 0.2}}};
  test.scene.view.step = 0.25;
  const Rgba seen = Renderer(test.scene).integrate({0.5, 0.5, 0.125}, kAlongZ);
  const double red = 1 - std::pow(0.9, 4.5), green = 1 - std::pow(0.8, 3.5);
  EXPECT_NEAR(seen.colour[0], red, kExact);
  EXPECT_NEAR(seen.colour[1], (1 - red) * green, kExact);
}

TEST(ShadedPlane, FacingTheLightShowsAmbientDiffuseAndSpecular) {
  TestScene test({9, 9, 9}, [](Vec3 p) { return p.z / 8; });
  test.surface(0.45, {0.8, 0.4, 0.2});  // the samples reach it at z = 4
  test.scene.view.shade = true;
  test.scene.shading.phong = {0.2, 0.5, 0.3, 10};
  const Rgba head_light = Renderer(test.scene).integrate({4, 4, -1}, kAlongZ);
  EXPECT_NEAR(head_light.colour[0], 0.8 * 0.7 + 0.3, kExact);
  EXPECT_NEAR(head_light.colour[2], 0.2 * 0.7 + 0.3, kExact);

  // The light 60 degrees off: N.L = 1/2, R.V = 1/2.
  test.scene.shading.light = {3 * std::sqrt(3.0), 0, -3};
  const Rgba slanted = Renderer(test.scene).integrate({4, 4, -1}, kAlongZ);
  const double shade = 0.2 + 0.5 * 0.5 + 0.3 * std::pow(0.5, 10);
  EXPECT_NEAR(slanted.colour[0], 0.8 * shade, kExact);

  test.scene.shading.light = {0, 0, 1};  // from behind
  EXPECT_NEAR(Renderer(test.scene).integrate({4, 4, -1}, kAlongZ).colour[0], 0.8 * 0.2, kExact);
}

TEST(ShadedPlane, OfAConstantVolumeIsNotShaded) {
  UniformScene test({4, 4, 4});
  test.look(1, {0.8, 0.4, 0.2});
  test.scene.view.shade = true;
  EXPECT_EQ(Renderer(test.scene).integrate({1, 1, 0}, kAlongZ), (Rgba{{0.8, 0.4, 0.2}, 1}));
}

TEST(Picture, FromInsideTheVolumeStartsAtTheEye) {
  UniformScene test({33, 33, 33});
  test.look(0.1);
  test.scene.view.eye = {16, 16, 20.25};
  test.scene.view.look_at = {16, 16, 32};
  test.scene.view.step = 0.5;
  test.scene.view.width = test.scene.view.height = 1;
  // Samples at 20.25, 20.75 .. 31.75: 24 of half a voxel.
  EXPECT_NEAR(1 - render(test.scene).at(0, 0).opacity, std::pow(0.9, 12), kExact);
}

TEST(Picture, DoesNotDependOnTheNumberOfThreads) {
  TestScene test({17, 17, 17}, [](Vec3 p) { return 0.5 + 0.5 * std::sin(p.x + 2 * p.y * p.z); });
  test.scene.functions[0] = {{{0, {1, 0, 0}}, {1, {0, 1, 1}}}, {{0.2, 0}, {1, 0.4}}};
  test.scene.view.width = 20;
  test.scene.view.height = 15;
  const Renderer renderer(test.scene);
  EXPECT_EQ(renderer.render(1).pixels, renderer.render(3).pixels);
}

}  // namespace
}  // namespace gicube::reference
