#include "transmittance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace gicube::reference {
namespace {

constexpr int kSize = 52;  // so that a ramp to 255 has whole values

// Values 0..255 that grow along x from 0 to 255.
std::vector<std::byte> ramp() {
  std::vector<std::byte> voxels(std::size_t{kSize} * kSize * kSize);
  for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<std::byte>(i % kSize * 255 / (kSize - 1));
  return voxels;
}

Scene scene_of(const std::vector<std::byte>& voxels, const TransferFunction& function) {
  Scene scene;
  scene.volume = {.samples = voxels, .dims = {kSize, kSize, kSize}};
  scene.functions[0] = function;
  return scene;
}

TEST(Transmittance, OfAFogIsExponentialInTheWay) {
  const auto voxels = ramp();
  TransferFunction function;
  function.colours = {{0, {1, 1, 1}}};
  function.opacities = {{0, 0.1}, {255, 0.1}};
  const Scene scene = scene_of(voxels, function);
  const Field field(scene.volume, {});
  const Vec3 a{1, 2, 3}, b{21, 12, 23};  // 30 voxels
  EXPECT_NEAR(transmittance(scene, field, a, b, 0.7), std::pow(0.9, 30), 1e-12);
  EXPECT_EQ(transmittance(scene, field, a, a, 0.7), 1);
}

TEST(Transmittance, OfAFogOfTwiceTheSpacingIsThatOfTwiceTheWay) {
  const auto voxels = ramp();
  TransferFunction function;
  function.colours = {{0, {1, 1, 1}}};
  function.opacities = {{0, 0.02}, {255, 0.02}};
  Scene scene = scene_of(voxels, function);
  scene.volume.spacing = {1, 2, 1};
  const Field field(scene.volume, {});
  EXPECT_NEAR(transmittance(scene, field, {4, 1, 4}, {4, 31, 4}, 0.5), std::pow(0.98, 60), 1e-12);
}

// Where the opacity grows linearly from 0 to p over the length L, the depth is the integral of -ln(1 - a).
TEST(Transmittance, OfARampIsItsIntegral) {
  const auto voxels = ramp();
  TransferFunction function;
  function.colours = {{0, {1, 1, 1}}};
  function.opacities = {{0, 0}, {255, 0.1}};
  const Scene scene = scene_of(voxels, function);
  const Field field(scene.volume, {});
  const double p = 0.1, integral = 51 / p * ((1 - p) * std::log(1 - p) + p);
  EXPECT_NEAR(transmittance(scene, field, {0, 9, 9}, {51, 9, 9}, 0.05), std::exp(-integral), 1e-6);
}

TEST(Transmittance, ThroughAnOpaqueSampleIsNone) {
  const auto voxels = ramp();
  TransferFunction function;
  function.colours = {{0, {1, 1, 1}}};
  function.opacities = {{0, 0}, {127, 0}, {128, 1}, {255, 1}};
  const Scene scene = scene_of(voxels, function);
  const Field field(scene.volume, {});
  EXPECT_EQ(transmittance(scene, field, {0, 9, 9}, {51, 9, 9}, 0.5), 0);
  EXPECT_EQ(transmittance(scene, field, {0, 9, 9}, {25, 20, 9}, 0.5), 1);
}

}  // namespace
}  // namespace gicube::reference
