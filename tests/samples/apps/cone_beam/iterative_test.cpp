// Conjugate gradients, ordered subsets of expectation maximisation and total variation; the axis of rotation from the
// data.
#include "cone_beam/algebraic.h"
#include "cone_beam/centre.h"
#include "cone_beam/phantom/phantom.h"
#include "open_board.h"
#include "reference/tomography.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

using std::numbers::pi;

const Phantom kObject = high_contrast_shepp_logan(42);

Reconstruction iterated(const ConeGeometry& geometry, const Projections& views, const AlgebraicSettings& settings) {
  Board board = open_board();
  return reconstruct_algebraic(board, geometry, views, settings);
}
double error_of(const ConeGeometry& geometry, const std::vector<float>& values) {
  return compare(geometry.volume, values, voxels(kObject, geometry.volume), {42, 20}).relative_l2;
}

// Two pixels a voxel along both axes.
ConeGeometry fine_scan(int views) {
  ConeGeometry geometry = small_scan(64, views);
  geometry.volume = {{32, 32, 32}, {90.0 / 32, 90.0 / 32, 90.0 / 32}};
  return geometry;
}

TEST(Cgls, IsThatOfDoublePrecision) {
  ConeGeometry geometry = small_scan(14, 10);
  const Projections views = project(kObject, geometry);
  const Reconstruction found = iterated(geometry, views, {.method = Method::kCgls, .iterations = 6, .step = 0.25});
  ProjectorSetup setup{.dims = geometry.volume.dims, .spacing = geometry.volume.spacing, .columns = 14, .rows = 14};
  for (std::size_t view = 0; view < 10; ++view) setup.views.push_back(pose(geometry, view));
  const std::vector<double> wanted =
      reference::cgls(setup, std::vector<double>(views.values.begin(), views.values.end()), 6);
  double off = 0, all = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    off += std::pow(double{found.values[i]} - wanted[i], 2);
    all += wanted[i] * wanted[i];
  }
  EXPECT_LT(std::sqrt(off / all), 0.02);
  ASSERT_EQ(found.residuals.size(), 6u);
  EXPECT_TRUE(std::is_sorted(found.residuals.rbegin(), found.residuals.rend()));
}

TEST(Cgls, NeedsFewerIterationsThanSirt) {
  const ConeGeometry geometry = fine_scan(40);
  const Projections views = project(kObject, geometry);
  const auto cgls = iterated(geometry, views, {.method = Method::kCgls, .iterations = 8});
  const auto sirt = iterated(geometry, views, {.method = Method::kSirt, .iterations = 8, .relaxation = 1.8});
  EXPECT_LT(cgls.residuals.back(), 0.8 * sirt.residuals.back());
  EXPECT_LT(error_of(geometry, cgls.values), 0.95 * error_of(geometry, sirt.values));
  EXPECT_LT(*std::ranges::min_element(cgls.values), 0);
}

TEST(Osem, ConvergesAndStaysPositive) {
  const ConeGeometry geometry = fine_scan(40);
  const Projections views = project(kObject, geometry);
  const auto found = iterated(geometry, views, {.method = Method::kOsem, .iterations = 3, .subsets = 10});
  EXPECT_FALSE(found.diverged);
  EXPECT_TRUE(std::is_sorted(found.residuals.rbegin(), found.residuals.rend()));
  EXPECT_LT(found.residuals.back(), 0.16);
  EXPECT_GE(*std::ranges::min_element(found.values), 0);
  const auto sart = iterated(geometry, views, {.method = Method::kSart, .iterations = 3, .relaxation = 0.3});
  EXPECT_LT(error_of(geometry, found.values), error_of(geometry, sart.values));
}

TEST(TotalVariation, GivesAnObjectOfFlatPartsFromFewNoisyViews) {
  const ConeGeometry geometry = fine_scan(16);
  const Phantom object{
      {1, {36, 30, 36}, {}, 0.3}, {-0.6, {9, 9, 9}, {12, -8, 3}, 0}, {0.5, {7, 7, 7}, {-14, 6, -2}, 0}};
  Projections views = project(object, geometry);
  for (float& value : views.values) value *= 0.03F;
  add_poisson_noise(views, 1000, 2);
  for (float& value : views.values) value /= 0.03F;
  AlgebraicSettings settings{.method = Method::kOsSart, .iterations = 20, .subsets = 10, .relaxation = 0.6};
  const std::vector<float> truth = voxels(object, geometry.volume);
  const auto error = [&] {
    return compare(geometry.volume, iterated(geometry, views, settings).values, truth, {42, 20}).rmse;
  };
  const double without = error();
  settings.method = Method::kTv;
  EXPECT_LT(error(), 0.85 * without);
}

// By differences of the sum itself.
TEST(TotalVariation, HasTheGradientOfItsSum) {
  const Dims dims{5, 4, 3};
  std::vector<float> values;
  for (int i = 0; i < 60; ++i) values.push_back(static_cast<float>(std::sin(1.7 * i) + 0.3 * (i % 4)));
  const auto total = [&](const std::vector<double>& field) {
    double sum = 0;
    for (std::size_t i = 0; i < 60; ++i) {
      const std::size_t x = i % 5, y = i / 5 % 4, z = i / 20;
      const double a = x < 4 ? field[i + 1] - field[i] : 0, b = y < 3 ? field[i + 5] - field[i] : 0;
      const double c = z < 2 ? field[i + 20] - field[i] : 0;
      sum += std::sqrt(a * a + b * b + c * c);
    }
    return sum;
  };
  const std::vector<float> slope = tv_gradient(values, dims);
  for (std::size_t i = 0; i < 60; ++i) {
    std::vector<double> up(values.begin(), values.end()), down = up;
    up[i] += 1e-4;
    down[i] -= 1e-4;
    EXPECT_NEAR(slope[i], (total(up) - total(down)) / 2e-4, 1e-3) << i;
  }
}

class Masked : public testing::TestWithParam<Method> {};

TEST_P(Masked, VoxelsStayNothingAndTheOthersAreNoWorse) {
  const ConeGeometry geometry = small_scan(24, 12);
  const Projections views = project(uniform_sphere(36, 1), geometry);
  const std::vector<float> truth = voxels(uniform_sphere(36, 1), geometry.volume);
  AlgebraicSettings settings{.method = GetParam(), .iterations = 4, .subsets = 4, .relaxation = 0.8};
  const auto free = iterated(geometry, views, settings);
  for (const float value : voxels(uniform_sphere(39, 1), geometry.volume)) settings.mask.push_back(value > 0 ? 1 : 0);
  const auto masked = iterated(geometry, views, settings);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (settings.mask[i] == 0) {
      ASSERT_EQ(masked.values[i], 0);
    }
  }
  EXPECT_LT(compare(geometry.volume, masked.values, truth).rmse,
            1.05 * compare(geometry.volume, free.values, truth).rmse);
}

INSTANTIATE_TEST_SUITE_P(All, Masked,
                         testing::Values(Method::kSart, Method::kSirt, Method::kCgls, Method::kOsem, Method::kTv));

TEST(Iterative, NamesWhatIsWrongOfTheNewSettings) {
  const ConeGeometry geometry = small_scan(16, 8);
  const Projections views = project(kObject, geometry);
  const auto saying = [](const char* text) { return ThrowsMessage<BadArgument>(HasSubstr(text)); };
  EXPECT_THAT([&] { iterated(geometry, views, {.method = Method::kOsem, .subsets = 9}); },
              saying("subsets: expected 2..the number"));
  EXPECT_THAT(
      [&] {
        iterated(geometry, views, {.mask = {1, 1}});
      },
      saying("mask: expected 4096 values, one a voxel, got 2"));
  EXPECT_THAT([&] { iterated(geometry, views, {.method = Method::kTv, .subsets = 4, .tv_steps = 0}); },
              saying("tv_steps"));
  EXPECT_THAT([&] { iterated(geometry, views, {.method = Method::kTv, .subsets = 4, .tv_weight = 2}); },
              saying("tv_weight"));
}

class PlantedCentre : public testing::TestWithParam<std::tuple<double, double>> {};

// The axis seen so many pixels beside the middle, in a scan over so many degrees, with noise.
TEST_P(PlantedCentre, IsFoundToATenthOfAPixel) {
  const auto [planted, arc] = GetParam();
  ConeGeometry geometry = small_scan(64, static_cast<int>(arc / 2), arc * pi / 180);
  geometry.detector.offset_u = planted * geometry.detector.pitch_u;
  const Phantom object{
      {1, {30, 22, 30}, {4, -3, 0}, 0.4}, {0.7, {6, 6, 6}, {-15, 6, 3}, 0}, {-0.5, {5, 5, 9}, {10, 2, -4}, 0}};
  Projections views = project(object, geometry);
  for (float& value : views.values) value *= 0.03F;
  add_poisson_noise(views, 20'000, 3);
  geometry.detector.offset_u = 0;
  EXPECT_NEAR(find_offset_u(geometry, views) / geometry.detector.pitch_u, planted, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Offsets, PlantedCentre,
                         testing::Values(std::tuple{0.0, 360.0}, std::tuple{0.37, 360.0}, std::tuple{-2.6, 360.0},
                                         std::tuple{9.45, 360.0}, std::tuple{-0.3, 220.0}, std::tuple{1.7, 240.0}));

TEST(PlantedCentre, IsNotLookedForWhereNoLineIsMeasuredTwice) {
  const ConeGeometry geometry = small_scan(32, 30, 100 * pi / 180);
  EXPECT_THROWS(BadArgument, "angles: expected an arc in which lines are measured from both sides",
                find_offset_u(geometry, project(kObject, geometry)));
}

}  // namespace
}  // namespace gicube::samples
