#include "cone_beam/algebraic.h"

#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "open_board.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

using testing::Each;
using testing::Lt;

const Phantom kHead = high_contrast_shepp_logan(42);

Reconstruction made(const ConeGeometry& geometry, const Projections& views, const AlgebraicSettings& settings) {
  Board board = open_board();
  return reconstruct_algebraic(board, geometry, views, settings);
}
double error(const ConeGeometry& geometry, const Reconstruction& made) {
  return compare(geometry.volume, made.values, voxels(kHead, geometry.volume), {42, 20}).rmse;
}

TEST(Sart, OfSixtyNoisyViewsIsBetterThanFdk) {
  const ConeGeometry geometry = small_scan(48, 60);
  // A head whose shadow is at most 1.2, seen by 10,000 photons a pixel.
  Projections views = project(kHead, geometry);
  for (float& value : views.values) value *= 0.05F;
  add_poisson_noise(views, 10'000, 1);
  for (float& value : views.values) value /= 0.05F;
  const Reconstruction sart = made(geometry, views, {.iterations = 4, .relaxation = 0.3});
  EXPECT_FALSE(sart.diverged);
  EXPECT_EQ(sart.overflowed, 0u);
  for (const Window window : {Window::kRamLak, Window::kSheppLogan, Window::kHann}) {
    Board board = open_board();
    const double fdk = error(geometry, reconstruct_fdk(board, geometry, views, {.window = window}));
    EXPECT_LT(error(geometry, sart), 0.92 * fdk);
  }
}

TEST(Sart, AUniformSpheresMeanIsWithinAPercent) {
  const ConeGeometry geometry = small_scan(32, 30);
  const Phantom ball = uniform_sphere(36, 0.5);
  const auto found = made(geometry, project(ball, geometry), {.iterations = 4, .relaxation = 0.5});
  const std::vector<float> truth(found.values.size(), 0.5F);
  EXPECT_NEAR(compare(geometry.volume, found.values, truth, {24, 8}).bias, 0, 0.005);
}

class Methods : public testing::TestWithParam<Method> {};

TEST_P(Methods, ResidualsFallAndErrorsToo) {
  const ConeGeometry geometry = small_scan(24, 24);
  const Projections views = project(kHead, geometry);
  AlgebraicSettings settings{.method = GetParam(), .iterations = 2, .subsets = 6, .relaxation = 0.3};
  const auto few = made(geometry, views, settings);
  settings.iterations = 6;
  const auto more = made(geometry, views, settings);
  ASSERT_EQ(more.residuals.size(), 6u);
  EXPECT_EQ(more.iterations, 6);
  EXPECT_EQ(more.residuals[1], few.residuals[1]) << "what goes before is the same";
  EXPECT_TRUE(std::is_sorted(more.residuals.rbegin(), more.residuals.rend()));
  EXPECT_LT(error(geometry, more), error(geometry, few));
  EXPECT_FALSE(more.diverged);
}

TEST_P(Methods, ARelaxationThatIsTooLargeIsReported) {
  const ConeGeometry geometry = small_scan(24, 24);
  const Projections views = project(kHead, geometry);
  for (const bool non_negative : {false, true}) {
    const auto found =
        made(geometry, views,
             {.method = GetParam(), .iterations = 30, .subsets = 6, .relaxation = 2.5, .non_negative = non_negative});
    EXPECT_TRUE(found.diverged) << non_negative;
    EXPECT_LT(found.residuals.size(), 30u);
    for (const float value : found.values) ASSERT_TRUE(std::isfinite(value));
    // The result is no worse than an empty volume.
    EXPECT_LE(error(geometry, found),
              error(geometry, Reconstruction{.values = std::vector<float>(found.values.size())}));
  }
}

INSTANTIATE_TEST_SUITE_P(All, Methods, testing::Values(Method::kSart, Method::kOsSart, Method::kSirt));

TEST(Algebraic, WhatIsNegativeIsCutOffOnlyOnRequest) {
  const ConeGeometry geometry = small_scan(24, 12);
  const Projections views = project(kHead, geometry);
  const auto cut = made(geometry, views, {.iterations = 2, .relaxation = 1});
  const auto free = made(geometry, views, {.iterations = 2, .relaxation = 1, .non_negative = false});
  EXPECT_EQ(std::min(0.0F, *std::min_element(cut.values.begin(), cut.values.end())), 0);
  EXPECT_LT(*std::min_element(free.values.begin(), free.values.end()), -0.02F);
}

TEST(Algebraic, StopsWhereItIsTold) {
  const ConeGeometry geometry = small_scan(24, 12);
  const Projections views = project(kHead, geometry);
  const auto all = made(geometry, views, {.iterations = 8, .relaxation = 1});
  ASSERT_EQ(all.residuals.size(), 8u);
  const auto by_noise = made(geometry, views, {.iterations = 8, .relaxation = 1, .noise = all.residuals[2]});
  EXPECT_EQ(by_noise.residuals.size(), 3u);
  const auto slow = made(geometry, views, {.iterations = 8, .relaxation = 1, .stop = 0.3});
  EXPECT_LT(slow.residuals.size(), 8u);
  const std::size_t last = slow.residuals.size() - 1;
  EXPECT_GT(slow.residuals[last], 0.7 * slow.residuals[last - 1]);
}

TEST(Algebraic, TheCycleLevelMakesTheSameBits) {
  const ConeGeometry geometry = small_scan(12, 4);
  const Projections views = project(kHead, geometry);
  Board functional = open_board(), cycle = open_board("&fidelity=cycle&set=asic.processors=3");
  const auto one = reconstruct_algebraic(functional, geometry, views, {.iterations = 1});
  const auto other = reconstruct_algebraic(cycle, geometry, views, {.iterations = 1});
  EXPECT_EQ(one.values, other.values);
  EXPECT_EQ(one.residuals, other.residuals);
}

TEST(Subsets, EveryViewIsInOne) {
  EXPECT_EQ(view_subsets(7, {.method = Method::kSart}).size(), 7u);
  EXPECT_THAT(view_subsets(5, {.method = Method::kSirt}), ElementsAre(ElementsAre(0, 1, 2, 3, 4)));
  EXPECT_THAT(view_subsets(5, {.method = Method::kOsSart, .subsets = 2}),
              ElementsAre(ElementsAre(0, 2, 4), ElementsAre(1, 3)));
}

TEST(Subsets, TheOrderHasEachOnceAndStaysAwayFromWhatItHasJustSeen) {
  const auto order = subset_order(60);
  EXPECT_EQ(std::set(order.begin(), order.end()).size(), 60u);
  EXPECT_THAT(order, Each(Lt(60u)));
  for (std::size_t i = 1; i < 60; ++i) {
    const int apart = std::abs(static_cast<int>(order[i]) - static_cast<int>(order[i - 1]));
    EXPECT_GE(std::min(apart, 60 - apart), 15) << i;
  }
}

TEST(Algebraic, WhatIsWrongIsNamed) {
  const ConeGeometry geometry = small_scan(16, 8);
  const Projections views = project(kHead, geometry);
  const auto saying = [](const char* text) { return ThrowsMessage<BadArgument>(HasSubstr(text)); };
  EXPECT_THAT([&] { made(geometry, views, {.iterations = 0}); }, saying("iterations: expected at least 1, got 0"));
  EXPECT_THAT([&] { made(geometry, views, {.relaxation = 0}); }, saying("relaxation"));
  EXPECT_THAT([&] { made(geometry, views, {.method = Method::kOsSart, .subsets = 9}); }, saying("subsets"));
  EXPECT_THAT([&] { made(geometry, views, {.stop = 1}); }, saying("stop"));
  EXPECT_THAT([&] { made(geometry, views, {.noise = -1}); }, saying("noise"));
  EXPECT_THAT([&] { made(geometry, views, {.step = 100}); }, saying("step"));
  ConeGeometry other = geometry;
  other.angles.pop_back();
  EXPECT_THAT([&] { made(other, views, {}); }, saying("projections"));
}

}  // namespace
}  // namespace gicube::samples
