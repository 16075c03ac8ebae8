#include "cone_beam/phantom/phantom.h"

#include "gicube/error.h"
#include "test.h"

namespace gicube::samples {
namespace {

const Grid kGrid{{12, 10, 8}, {1, 1, 2}};

std::vector<float> noise(double mean, double deviation, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> value(mean, deviation);
  std::vector<float> out(12 * 10 * 8);
  for (float& v : out) v = static_cast<float>(value(engine));
  return out;
}

TEST(Comparison, EqualVolumesDifferInNothing) {
  const auto values = noise(1, 0.5, 1);
  const Comparison found = compare(kGrid, values, values);
  EXPECT_EQ(found.voxels, values.size());
  EXPECT_EQ(found.rmse, 0);
  EXPECT_EQ(found.bias, 0);
  EXPECT_EQ(found.relative_l2, 0);
  EXPECT_TRUE(std::isinf(found.psnr));
  EXPECT_NEAR(found.ssim, 1, 1e-9);
}

TEST(Comparison, AFieldOfViewWithoutVoxelsIsNamed) {
  const auto values = noise(1, 0.5, 1);
  EXPECT_THROWS(BadArgument, "got radius 0.1, half height 0.2", compare(kGrid, values, values, {0.1, 0.2}));
}

TEST(Comparison, AnOffsetIsBiasAndRmse) {
  auto values = noise(0, 0, 1), truth = values;
  truth[5] = 4;  // a span for PSNR
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = truth[i] - 0.04F;
  const Comparison found = compare(kGrid, values, truth);
  EXPECT_NEAR(found.rmse, 0.04, 1e-6);
  EXPECT_NEAR(found.bias, -0.04, 1e-6);
  EXPECT_NEAR(found.psnr, 40, 1e-4);
  EXPECT_NEAR(found.relative_l2, 0.04 / (4 / std::sqrt(960.0)), 1e-5);
}

TEST(Comparison, OnlyTheFieldOfViewCounts) {
  const auto truth = noise(1, 0.1, 2);
  auto values = truth;
  values[0] += 100;  // a corner
  const FieldOfView field{4, 3};
  EXPECT_EQ(compare(kGrid, values, truth, field).rmse, 0);
  EXPECT_GT(compare(kGrid, values, truth).rmse, 3);
  // Centres at +-0.5, .. 5.5 by +-0.5, .. 4.5 in each slice; slices at +-1, 3, 5, 7.
  std::size_t expected = 0;
  for (double x = -5.5; x < 6; ++x) {
    for (double y = -4.5; y < 5; ++y) expected += std::hypot(x, y) <= 4 ? 4 : 0;
  }
  EXPECT_EQ(compare(kGrid, values, truth, field).voxels, expected);
}

// Two of the voxels that differ along x alone: both windows hold both.
TEST(Similarity, OfTwoVoxelsIsAsByHand) {
  const Grid grid{{2, 2, 2}, {1, 1, 1}};
  const std::vector<float> truth{0, 1, 0, 1, 0, 1, 0, 1};
  const std::vector<float> values{0.25F, 0.5F, 0.25F, 0.5F, 0.25F, 0.5F, 0.25F, 0.5F};
  const double other = std::exp(-1 / 4.5), near = 1 / (1 + other), far = other / (1 + other);
  const auto at = [&](double here, double there) {
    const double a = here * 0.25 + there * 0.5, b = there, variance_a = here * there / 16, variance_b = here * there;
    const double covariance = here * there / 4;
    return (2 * a * b + 1e-4) * (2 * covariance + 9e-4) / ((a * a + b * b + 1e-4) * (variance_a + variance_b + 9e-4));
  };
  EXPECT_NEAR(compare(grid, values, truth).ssim, (at(near, far) + at(far, near)) / 2, 1e-6);
}

TEST(Similarity, FallsWithNoiseAndWithWhatIsTurnedRound) {
  std::vector<float> truth;
  for (int i = 0; i < 960; ++i) truth.push_back(static_cast<float>((i / 3) % 2));
  const auto with = [&](double deviation) {
    auto values = noise(0, deviation, 3);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] += truth[i];
    return compare(kGrid, values, truth).ssim;
  };
  EXPECT_GT(with(0.02), 0.99);
  EXPECT_LT(with(0.3), with(0.1));
  EXPECT_LT(with(3), 0.3);
  auto turned = truth;
  for (float& value : turned) value = 1 - value;
  EXPECT_LT(compare(kGrid, turned, truth).ssim, -0.5);
}

TEST(Profile, RunsAlongOneAxis) {
  const Grid grid{{3, 2, 2}, {1, 1, 1}};
  const std::vector<float> values{0, 1, 2, 10, 11, 12, 100, 101, 102, 110, 111, 112};
  EXPECT_THAT(profile(grid, values, 0, {0, 1, 1}), ElementsAre(110, 111, 112));
  EXPECT_THAT(profile(grid, values, 1, {2, 0, 0}), ElementsAre(2, 12));
  EXPECT_THAT(profile(grid, values, 2, {1, 1, 0}), ElementsAre(11, 111));
  EXPECT_THROWS(BadArgument, "through[0]: expected 0..2, got 3", profile(grid, values, 2, {3, 0, 0}));
  EXPECT_THROW(profile(grid, values, 3, {0, 0, 0}), BadArgument);
}

TEST(Comparison, WhatDoesntFitIsNamed) {
  const std::vector<float> few(3), all(960);
  EXPECT_THROWS(BadArgument, "values: expected 960 values", compare(kGrid, few, all));
  EXPECT_THROWS(BadArgument, "truth", compare(kGrid, all, few));
  EXPECT_THROWS(BadArgument, "field of view", compare(kGrid, all, all, {0.1, 0.1}));
  EXPECT_THROW(differences(few, all), BadArgument);
  EXPECT_THAT(differences(std::vector<float>{3, 1}, std::vector<float>{1, 2}), ElementsAre(2, -1));
}

}  // namespace
}  // namespace gicube::samples
