// Opacity correction: alpha near 1 with small steps, and alpha below one unit of its words.
#include <cmath>
#include <random>

#include "stability.h"

namespace gicube::stability {
namespace {

constexpr double kAlphaOne = 65'535;  // classified opacity
constexpr double kLongest = 250;      // voxels

class StabilityOfOpacityCorrection : public testing::Test {
 protected:
  void fog(double alpha) { load_fog(board_, {256, 8, 8}, alpha); }
  void alpha(double alpha) { board_.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, alpha}}}); }
  void widen() { board_ = Board::open("emu:?set=asic.block_voxels=16&set=asic.datapath=wide"); }
  // The opacity of rays side by side, which must agree.
  double opacity(double length, double step) {
    constexpr std::uint32_t kRays = 24;
    std::vector<HostRay> rays;
    for (std::uint32_t i = 0; i < kRays; ++i) {
      const double y = 1 + 0.25 * i;
      rays.push_back(ray_between(i, {2, y, 3.5}, {2 + length, y, 3.5}));
    }
    const RayBatch batch = board_.receive(board_.submit(rays, {.type = RayType::kOpacity, .step = step}));
    for (const TracedRay& ray : batch.rays) EXPECT_EQ(ray.opacity, batch.rays[0].opacity);
    return batch.rays.at(0).opacity;
  }

  Board board_ = Board::open("emu:?set=asic.block_voxels=16");
};

TEST_F(StabilityOfOpacityCorrection, FullScaleStaysOneWhereOneUnitLessLetsMostLightThrough) {
  fog(1);
  for (const double step : {1.0 / 64, 0.1, 0.5, 1.0}) EXPECT_EQ(opacity(step, step), 1) << step;
  alpha(1 - 1 / kAlphaOne);
  for (const double step : {1.0 / 64, 0.1, 0.5, 1.0}) {
    const double expected = 1 - std::pow(1 / kAlphaOne, std::round(step * kStepOne) / kStepOne);
    EXPECT_NEAR(opacity(step, step), expected, 2e-6) << step;
    if (step < 0.02) record("opacity_of_65534_at_a_step_of_1_64", opacity(step, step));
  }
}

// The words' part of the error: their last place, once for each sample in the ray's 24 bits and once in the table's 16.
TEST_F(StabilityOfOpacityCorrection, ThinFogKeepsItsTransmittanceWithinTheBound) {
  fog(0.5);
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> exponent(-6, -1);
  double worst = 0, worst_share = 0;
  for (int i = 0; i < 120; ++i) {
    const double thin = std::pow(10, exponent(engine));
    alpha(thin);
    for (const double step : {1.0 / 64, 0.5, 1.0}) {
      const double error = std::abs(1 - opacity(kLongest, step) - std::pow(1 - thin, kLongest));
      const double bound = kLongest / (2 * kAlphaOne) + 2 * kLongest / step / (1 << 24);
      ASSERT_LE(error, bound) << thin << " " << step;
      worst = std::max(worst, error);
      worst_share = std::max(worst_share, error / bound);
    }
  }
  record("worst_transmittance_error_of_250_voxels", worst);
  EXPECT_GT(worst_share, 0.3) << "the bound says nothing";
}

// Steps of one length each, rounded to 2^-16 voxel, and the segment's own length too: n + 1 errors of half a unit,
// times the extinction and the transmittance, whose product is at most 1 / (e L).
TEST_F(StabilityOfOpacityCorrection, SegmentsThatStepsDoNotDivideKeepTheirTransmittanceWithinTheirBound) {
  for (const bool is_wide : {false, true}) {
    if (is_wide) widen();
    fog(0.5);
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> exponent(-4, -1), span(1, kLongest);
    double worst_share = 0, worst_without = 0;
    for (int i = 0; i < 120; ++i) {
      const double thin = std::pow(10, exponent(engine));
      const double length = std::round((i % 2 == 0 ? span(engine) : 1 + span(engine) / 25) * 1024) / 1024 + 0.3 / 1024;
      alpha(thin);
      for (const double step : {1.0 / 64, 0.1, 0.37, 0.7, 1.0}) {
        const double n = std::ceil(std::round(length * 65'536) / std::round(step * 65'536));
        const double error = std::abs(1 - opacity(length, step) - std::pow(1 - thin, length));
        const double words =
            is_wide ? length * 0x1p-29 + n * 0x1p-25 + 0x1p-22 : length / (2 * kAlphaOne) + 2 * n / (1 << 24);
        const double bound = words + (n + 1) * 0x1p-17 / (std::exp(1) * length);
        ASSERT_LE(error, bound) << thin << " over " << length << " in steps of " << step << (is_wide ? ", wide" : "");
        worst_share = std::max(worst_share, error / bound);
        worst_without = std::max(worst_without, error / words);
      }
    }
    EXPECT_GT(worst_share, 0.3) << "the bound says nothing";
    EXPECT_GT(worst_without, is_wide ? 5 : 1) << "a step's length does not count";
    record(std::string("worst_error_of_segments_over_the_bound_of_words") + (is_wide ? "_wide" : ""), worst_without);
  }
}

TEST_F(StabilityOfOpacityCorrection, FogBelowHalfAUnitIsNotSeenAndFromThereOnIs) {
  fog(0.49 / kAlphaOne);
  EXPECT_EQ(opacity(kLongest, 0.5), 0);
  record("transmittance_error_of_fog_that_is_not_seen", 1 - std::pow(1 - 0.49 / kAlphaOne, kLongest));
  alpha(0.51 / kAlphaOne);
  EXPECT_NEAR(opacity(kLongest, 0.5), 1 - std::pow(1 - 1 / kAlphaOne, kLongest), 6e-5);
}

// Half a unit of 2^-28 in the table for each voxel, half of 2^-24 in the float for each sample, and what one sample and
// the returned word are rounded by.
TEST_F(StabilityOfOpacityCorrection, TheWideDatapathKeepsThinFogsTransmittanceWithinItsOwnBound) {
  widen();
  fog(0.5);
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> exponent(-9, -1);
  double worst = 0, worst_at_half = 0, worst_share = 0;
  for (int i = 0; i < 120; ++i) {
    const double thin = std::pow(10, exponent(engine));
    alpha(thin);
    for (const double step : {1.0 / 64, 0.5, 1.0}) {
      const double error = std::abs(1 - opacity(kLongest, step) - std::pow(1 - thin, kLongest));
      const double bound = kLongest * 0x1p-29 + kLongest / step * 0x1p-25 + 0x1p-22;
      ASSERT_LE(error, bound) << thin << " " << step;
      worst = std::max(worst, error);
      if (step == 0.5) worst_at_half = std::max(worst_at_half, error);
      worst_share = std::max(worst_share, error / bound);
    }
  }
  record("worst_transmittance_error_of_250_voxels_wide", worst);
  record("worst_transmittance_error_of_250_voxels_wide_half_steps", worst_at_half);
  EXPECT_LT(worst_at_half, 1e-5);
  EXPECT_GT(worst_share, 0.05) << "the bound says nothing";
}

TEST_F(StabilityOfOpacityCorrection, TheWideDatapathSeesFogBelowOneUnitOfTheTable) {
  widen();
  fog(0.5);
  for (const double thin : {0.49 / kAlphaOne, 0.01 / kAlphaOne}) {
    alpha(thin);
    const double expected = -std::expm1(kLongest * std::log1p(-thin));
    EXPECT_NEAR(opacity(kLongest, 0.5), expected, 1.5e-7 + 0.02 * expected) << thin;
  }
  alpha(0.49 / kAlphaOne);
  record("transmittance_error_of_fog_below_a_unit_wide",
         std::abs(1 - opacity(kLongest, 0.5) - std::pow(1 - 0.49 / kAlphaOne, kLongest)));
  alpha(1);
  for (const double step : {1.0 / 64, 0.5}) EXPECT_EQ(opacity(step, step), 1) << step;
}

// Of light in fog so thin that no ray of 8 bits loses a whole unit.
TEST_F(StabilityOfOpacityCorrection, TheWideDatapathTakesTheNoiseFromLightInThinFog) {
  const double thin = 2 / kAlphaOne, expected = -std::expm1(31 * std::log1p(-thin));
  const auto absorbed = [&](const char* datapath) {
    Board board = Board::open(small_board(std::string("&set=asic.datapath=") + datapath));
    EXPECT_EQ(board.info().wide, std::string_view(datapath) == "wide");
    load_fog(board, {32, 32, 32}, thin);
    const std::vector<Light> sun{DirectionalLight{{-1, 0, 0}, 1}};
    const LightingReport report = board.illuminate(sun, {.rays_per_face_voxel = 4});
    EXPECT_EQ(report.clipped, 0);
    return report.deposited / report.emitted;
  };
  const double paper = std::abs(absorbed("paper") / expected - 1), wide = std::abs(absorbed("wide") / expected - 1);
  record("error_of_light_absorbed_in_thin_fog_paper", paper);
  record("error_of_light_absorbed_in_thin_fog_wide", wide);
  EXPECT_LT(paper, 0.15);
  EXPECT_LT(wide, 0.005);
}

}  // namespace
}  // namespace gicube::stability
