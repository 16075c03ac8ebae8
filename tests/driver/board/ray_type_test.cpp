// What host rays of each type bring back, against what the volume must give.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

// A box of opacity 0.1 a voxel at 8..23 of 32^3: its faces lie half a voxel further out, at 7.5 and 23.5, for the
// step function falls between the samples.
class RayTypes : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { load_box(board_); }
  TracedRay trace(const HostRay& ray, const RayRequest& request) {
    return board_.receive(board_.submit(std::span(&ray, 1), request)).rays.at(0);
  }

  Board board_ = Board::open(std::string(kSmallBlocks) + "&fidelity=" + GetParam());
};

TEST_P(RayTypes, TheFirstHitIsTheSampleThatBringsTheOpacityThere) {
  const HostRay ray{.id = 9, .position = {16, 16, 0}, .direction = {0, 0, 1}};
  const TracedRay first = trace(ray, {.type = RayType::kFirstHit, .opacity = 1e-6, .step = 0.25});
  EXPECT_EQ(first.id, 9u);
  EXPECT_NEAR(first.position.z, 7.5, 0.26);
  EXPECT_GT(first.opacity, 0);
  EXPECT_EQ(first.colour, (std::array<double, 3>{}));
  // 1 - 0.9^z = 0.5 at z = 6.58 voxels.
  const TracedRay half = trace(ray, {.type = RayType::kFirstHit, .opacity = 0.5, .step = 0.25});
  EXPECT_NEAR(half.position.z, 7.5 + 6.58, 0.3);
  EXPECT_NEAR(half.opacity, 0.5, 0.02);
  EXPECT_GE(half.opacity, 0.5);
  EXPECT_DOUBLE_EQ(half.position.x, 16);
}

TEST_P(RayTypes, StepAndLeapAreTheRequestsWhateverWasRenderedBefore) {
  const HostRay ray{.position = {16, 16, 0}, .direction = {0, 0, 1}};
  const RayRequest coarse{.type = RayType::kFirstHit, .step = 2};
  const TracedRay before = trace(ray, coarse), by_default = trace(ray, {.type = RayType::kFirstHit});
  View view = front_view(32);
  view.step = 0.25, view.leap = false;
  board_.render_to_framebuffer(view);
  EXPECT_EQ(trace(ray, coarse), before);
  EXPECT_EQ(trace(ray, {.type = RayType::kFirstHit}), by_default);
  const auto leaps = [&](bool leap) {
    const Counters counters = board_.counters();
    EXPECT_EQ(trace(ray, {.type = RayType::kFirstHit, .leap = leap}), by_default);
    return (board_.counters() - counters).value("pipeline.leaps");
  };
  EXPECT_GT(leaps(true), 0u);
  EXPECT_EQ(leaps(false), 0u);
}

TEST_P(RayTypes, WhoHitsNothingStandsWhereItLeftTheVolume) {
  const TracedRay miss =
      trace({.position = {2, 2, 0}, .direction = {0, 0, 1}}, {.type = RayType::kFirstHit, .opacity = 0.5});
  EXPECT_EQ(miss.opacity, 0);
  EXPECT_DOUBLE_EQ(miss.position.z, 31);
  const TracedRay thin =
      trace({.position = {16, 16, 0}, .direction = {0, 0, 1}}, {.type = RayType::kFirstHit, .opacity = 0.99});
  EXPECT_NEAR(thin.opacity, 1 - std::pow(0.9, 16), 0.02);
}

TEST_P(RayTypes, OpacityBetweenTwoPointsIsThatOfTheWayBetweenThem) {
  const auto opacity = [&](Vec3 from, Vec3 to) {
    return trace(ray_between(0, from, to), {.type = RayType::kOpacity}).opacity;
  };
  EXPECT_NEAR(opacity({16, 16, 10}, {16, 16, 14}), 1 - std::pow(0.9, 4), 1e-4);
  EXPECT_NEAR(opacity({12, 10, 9}, {15, 14, 9}), 1 - std::pow(0.9, 5), 1e-4);
  EXPECT_NEAR(opacity({12, 10, 9}, {12.3, 10, 9}), 1 - std::pow(0.9, 0.3), 1e-4);
  EXPECT_EQ(opacity({2, 2, 2}, {2, 29, 2}), 0);
  EXPECT_EQ(opacity({12, 10, 9}, {12, 10, 9}), 0);
  EXPECT_NEAR(opacity({16, 16, 0}, {16, 16, 31}), 1 - std::pow(0.9, 16), 0.02);
}

TEST_P(RayTypes, BothDirectionsOfASegmentSeeTheSame) {
  std::vector<HostRay> there, back;
  for (int i = 0; i < 200; ++i) {
    const double a = i * 0.7, b = i * 1.3;
    const Vec3 from{15.5 + 15 * std::sin(a), 15.5 + 15 * std::cos(b), 15.5 + 15 * std::sin(a + b)};
    const Vec3 to{15.5 + 15 * std::cos(2 * a), 15.5 - 15 * std::sin(b), 15.5 + 15 * std::cos(a - b)};
    there.push_back(ray_between(static_cast<std::uint32_t>(i), from, to));
    back.push_back(ray_between(static_cast<std::uint32_t>(i), to, from));
  }
  const RayBatch one = board_.receive(board_.submit(there, {.type = RayType::kOpacity}));
  const RayBatch other = board_.receive(board_.submit(back, {.type = RayType::kOpacity}));
  for (std::size_t i = 0; i < 200; ++i) {
    // A sample can fall to the other side of the step function by the rounding of its place.
    EXPECT_NEAR(one.rays[i].opacity, other.rays[i].opacity, 0.03) << i;
    EXPECT_NEAR(one.rays[i].position.x, back[i].position.x, 0.02) << i;
    EXPECT_NEAR(one.rays[i].position.y, back[i].position.y, 0.02) << i;
    EXPECT_NEAR(one.rays[i].position.z, back[i].position.z, 0.02) << i;
  }
}

TEST_P(RayTypes, ASegmentEndsAtTheOpacityThatWasAskedFor) {
  const TracedRay ray = trace(ray_between(0, {16, 16, 9}, {16, 16, 23}), {.type = RayType::kOpacity, .opacity = 0.5});
  EXPECT_GE(ray.opacity, 0.5);
  EXPECT_LT(ray.opacity, 0.53);
  EXPECT_NEAR(ray.position.z, 9 + 6.58, 0.6);
}

TEST_P(RayTypes, ASegmentWithColourHasTheColourOfAnIntegratedRay) {
  View view = front_view(32);
  view.shade = false;
  view.opacity_threshold = 1;
  const Sampling sampling = sampling_of(view);
  const TracedRay whole = trace({.position = {16, 16, 0}, .direction = {0, 0, 1}}, {.sampling = sampling});
  const TracedRay segment =
      trace(ray_between(0, {16, 16, 0}, {16, 16, 31}), {.type = RayType::kSegment, .sampling = sampling});
  EXPECT_NEAR(segment.opacity, whole.opacity, 0.02);
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(segment.colour[c], whole.colour[c], 0.02);
  EXPECT_GT(segment.colour[0], 0.3);
}

TEST_P(RayTypes, DepositedEnergyIsInTheIrradianceAndInTheReport) {
  board_.clear_irradiance(0.5);
  std::vector<HostRay> rays;
  for (std::uint32_t i = 0; i < 100; ++i) {
    const std::uint32_t column = i % 10, row = i / 10;
    rays.push_back({.id = i, .position = {10.0 + column, 10.0 + row, 0}, .direction = {0, 0, 1}, .energy = 20});
  }
  const RayBatch batch = board_.receive(board_.submit(rays, {.type = RayType::kDeposit}));
  EXPECT_TRUE(batch.rays.empty());
  ASSERT_TRUE(batch.lighting);
  const LightingReport& report = *batch.lighting;
  EXPECT_EQ(report.rays, 100u);
  EXPECT_DOUBLE_EQ(report.emitted, 2000);
  EXPECT_DOUBLE_EQ(report.deposited + report.escaped + report.scattered_away + report.clipped, report.emitted);
  EXPECT_NEAR(report.deposited, 2000 * (1 - std::pow(0.9, 16)), 40);
  double sum = 0;
  for (const float value : board_.read_irradiance()) sum += static_cast<double>(value);
  EXPECT_NEAR(sum, report.deposited, 1e-6 * sum);
  // A second batch adds to it.
  board_.receive(board_.submit(rays, {.type = RayType::kDeposit, .albedo = Albedo::kLow}));
  double twice = 0;
  for (const float value : board_.read_irradiance()) twice += static_cast<double>(value);
  EXPECT_NEAR(twice, 2 * sum, 0.05 * sum);
}

TEST_P(RayTypes, DepositsNeedAUnitAndAnEnergyThatFits) {
  const HostRay ray{.position = {1, 1, 1}, .direction = {0, 0, 1}, .energy = 1};
  EXPECT_THROW(trace(ray, {.type = RayType::kDeposit}), Rejected);
  board_.clear_irradiance(0.001);
  EXPECT_THROWS(BadArgument, "rays[0].energy: expected ", trace(ray, {.type = RayType::kDeposit}));
  EXPECT_THROW(board_.clear_irradiance(0), BadArgument);
}

TEST_P(RayTypes, ABadRequestIsNamed) {
  const HostRay ray{.position = {1, 1, 1}, .direction = {0, 0, 1}, .length = 5000};
  EXPECT_THROWS(BadArgument, "request.opacity: expected more than 0, at most 1, got 0",
                trace(ray, {.type = RayType::kFirstHit, .opacity = 0}));
  EXPECT_THROWS(BadArgument, "rays[0].length: expected 0..4096, got 5000", trace(ray, {.type = RayType::kOpacity}));
}

INSTANTIATE_TEST_SUITE_P(Levels, RayTypes, testing::Values("functional", "cycle"),
                         [](const auto& level) { return std::string(level.param); });

}  // namespace
}  // namespace gicube
