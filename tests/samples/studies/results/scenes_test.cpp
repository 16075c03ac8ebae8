#include "studies/results/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gicube::samples::results {
namespace {

constexpr int kEdge = 32;

std::vector<double> values_of(const SceneData& scene) {
  std::vector<double> values;
  for (std::size_t at = 0; at < scene.volume.samples.size(); at += 2) {
    std::uint16_t word = 0;
    std::memcpy(&word, &scene.volume.samples[at], sizeof word);
    values.push_back(word);
  }
  return values;
}

// Natural logarithm of what a ray of `voxels` through the value lets pass.
double depth(const SceneData& scene, double value, double voxels) {
  return -voxels * std::log(1 - scene.materials.front().function.opacity_at(value));
}

TEST(ResultScenes, CloudIsVisibleEverywhereAndNeverOpaque) {
  const SceneData cloud = make_scene("cloud", {kEdge, kEdge, kEdge}, kEdge, 1);
  const std::vector<double> values = values_of(cloud);
  ASSERT_EQ(values.size(), std::size_t{kEdge} * kEdge * kEdge);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  EXPECT_GT(cloud.materials.front().function.opacity_at(*least), 0);
  EXPECT_LT(depth(cloud, *most, std::sqrt(3) * kEdge), -std::log(1 - 0.98));  // even its densest value on the diagonal
}

TEST(ResultScenes, RockIsOpaqueWithinItsEdge) {
  const SceneData rock = make_scene("rock", {kEdge, kEdge, kEdge}, kEdge, 1);
  const std::vector<double> values = values_of(rock);
  const double least = *std::min_element(values.begin(), values.end());
  EXPECT_GT(depth(rock, least, kEdge - 1), -std::log(1 - 0.98));
}

TEST(ResultScenes, HeadLeavesCornersEmpty) {
  const SceneData head = make_scene("head", {kEdge, kEdge, kEdge}, kEdge, 1);
  const std::vector<double> values = values_of(head);
  EXPECT_EQ(values.front(), 0);
  EXPECT_EQ(values.back(), 0);
  EXPECT_GT(head.box.low.x, 1);
  EXPECT_LT(head.box.high.x, kEdge - 2);
}

TEST(ResultScenes, FaintLooksShowTheSameValues) {
  for (const char* name : {"buckyball", "head", "cloud", "rock"}) {
    const SceneData scene = make_scene(name, {kEdge, kEdge, kEdge}, kEdge, 1);
    const TransferFunction &plain = scene.materials.front().function, thin = faint(plain);
    for (double value = 0; value <= 4095; value += 65) {
      EXPECT_EQ(plain.opacity_at(value) > 0, thin.opacity_at(value) > 0) << name << ' ' << value;
      EXPECT_LT(thin.opacity_at(value), 0.0031);
    }
  }
}

TEST(ResultScenes, LitScenesAreTheShippedOnesAtTheSizeAskedFor) {
  ASSERT_EQ(lit_scene_texts().size(), 4u);
  for (const auto& [name, text] : lit_scene_texts()) {
    const SceneData scene = make_scene(name, {kEdge, kEdge, kEdge}, kEdge, 1);
    EXPECT_EQ(*std::max_element(scene.volume.dims.begin(), scene.volume.dims.end()), kEdge) << name;
    EXPECT_FALSE(scene.lights.empty()) << name;
    EXPECT_TRUE(std::any_of(scene.optics.begin(), scene.optics.end(), [](const Material& material) {
      return material.scattering > 0 && material.bsdf != Bsdf::kNone;
    })) << name;
    const View view = make_view(scene, "oblique", 40, 30);
    EXPECT_EQ(view.width, 40);
    EXPECT_EQ(view.samples_per_axis, 1);  // one ray a pixel, as the paper's images
    EXPECT_GT(view.exposure, 0);
  }
}

TEST(ResultScenes, ViewsAlongAnAxisSeeTheWholeVolumeFromOutside) {
  const SceneData cloud = make_scene("cloud", {kEdge, kEdge, kEdge}, kEdge, 1);
  const View x = make_view(cloud, "along x", 64, 64);
  EXPECT_DOUBLE_EQ(x.eye.y, x.look_at.y);
  EXPECT_DOUBLE_EQ(x.eye.z, x.look_at.z);
  EXPECT_LT(x.eye.x, 0);
  // The near face just fits: its half edge over its distance is a little below the tangent.
  const double tangent = std::tan(15 * std::acos(-1.0) / 180), half = 0.5 * (kEdge - 1);
  EXPECT_LT(half / -x.eye.x, tangent);
  EXPECT_GT(half / -x.eye.x, 0.95 * tangent);
}

}  // namespace
}  // namespace gicube::samples::results
