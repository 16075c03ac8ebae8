// Backprojection: sparse rays, words without a sign, wide cones, truncated views, few views, noise, and too much
// relaxation.
#include <complex>

#include "../samples/apps/cone_beam/small_scan.h"
#include "cone_beam/algebraic.h"
#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "reference/fdk.h"
#include "stability.h"
#include "test.h"

namespace gicube::stability {
namespace {

using namespace samples;
using std::numbers::pi;

class StabilityOfBackprojection : public testing::Test {
 protected:
  // Root mean square difference to the phantom's voxels within the field of view.
  static Comparison error(const ConeGeometry& geometry, const std::vector<float>& values, const Phantom& phantom,
                          double radius = 40, double half_height = 20) {
    return compare(geometry.volume, values, voxels(phantom, geometry.volume), {radius, half_height});
  }
  Reconstruction fdk(const ConeGeometry& geometry, const Projections& views, const FdkSettings& settings = {}) {
    return reconstruct_fdk(board_, geometry, views, settings);
  }
  Reconstruction sart(const ConeGeometry& geometry, const Projections& views, double relaxation, int iterations = 6) {
    return reconstruct_algebraic(board_, geometry, views, {.iterations = iterations, .relaxation = relaxation});
  }

  Board board_ = Board::open("emu:?set=asic.block_voxels=16&set=asic.max_volume_voxels=64");
};

// What rays along x, `spacing` voxels apart along y, leave of a ripple in a sum that should be flat.
TEST_F(StabilityOfBackprojection, RaysFartherApartThanVoxelsLeaveARippleOfSincSquared) {
  constexpr int kSize = 64;
  load_fog(board_, {kSize, kSize, 4}, 0);
  const auto ripple = [&](double spacing, std::span<const float> weights, std::vector<float>& sums) {
    board_.clear_sums(1e-5);
    std::vector<HostRay> rays;
    for (double y = 0; y <= kSize - 1; y += spacing) {
      rays.push_back(ray_between(0, {1, y, 2}, {62, y, 2}));
      rays.back().energy = 1;
    }
    board_.receive(board_.submit(rays, {.type = RayType::kBackproject, .step = 1}));
    sums = board_.read_sums({{32, 0, 2}, {1, kSize, 1}});
    std::complex<double> wave = 0;
    double mean = 0;
    for (std::size_t y = 7; y < 57; ++y) {  // a whole number of waves of all spacings below
      const double sum = double{sums[y]} / (weights.empty() ? 1 : double{weights[y]});
      wave += std::polar(sum, 2 * pi * static_cast<double>(y) / spacing);
      mean += sum;
    }
    return std::abs(wave) / mean;
  };
  for (const double spacing : {0.5, 1 / 1.3, 1.0, 1.25, 1 / 0.7}) {
    const double x = pi / spacing, expected = std::pow(std::sin(x) / x, 2);
    std::vector<float> ones, again;
    // At spacings of whole fractions of a voxel, the wave itself is not seen at voxels.
    if (std::abs(1 / spacing - std::round(1 / spacing)) > 0.01) {
      EXPECT_NEAR(ripple(spacing, {}, ones), expected, 0.01) << spacing;
      // Normalised by what the same rays leave of ones, nothing is left of it.
      EXPECT_NEAR(ripple(spacing, ones, again), 0, 1e-6) << spacing;
    } else {
      ripple(spacing, {}, ones);
      const auto [least, most] = std::minmax_element(ones.begin() + 7, ones.begin() + 57);
      EXPECT_NEAR(*most / *least, 1, 0.002) << spacing;
    }
    if (spacing > 1.3) record("ripple_of_rays_1.43_voxels_apart", ripple(spacing, {}, ones));
  }
}

TEST_F(StabilityOfBackprojection, SumsOfSignedDataAreExactInAnyOrder) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> place(0, 31), energy(-1, 1);
  std::vector<HostRay> rays;
  for (std::uint32_t i = 0; i < 6000; ++i) {
    rays.push_back(
        ray_between(i, {place(engine), place(engine), place(engine)}, {place(engine), place(engine), place(engine)}));
    rays.back().energy = energy(engine);
  }
  load_fog(board_, {32, 32, 32}, 0);
  const auto sums = [&] {
    board_.clear_sums(1e-6);
    const BatchReport report = board_.receive(board_.submit(rays, {.type = RayType::kBackproject}));
    EXPECT_EQ(report.deposits.value().overflowed, 0u);
    return board_.read_sums({{0, 0, 0}, {32, 32, 32}});
  };
  const std::vector<float> forward = sums();
  std::reverse(rays.begin(), rays.end());
  EXPECT_EQ(sums(), forward);
  // Each ray and its opposite leave nothing but halves that were rounded up.
  const float most = *std::max_element(forward.begin(), forward.end());
  for (std::size_t i = 0, count = rays.size(); i < count; ++i) {
    rays.push_back(rays[i]);
    rays.back().energy *= -1;
  }
  for (const float sum : sums()) ASSERT_LE(std::abs(sum), 1e-4F * most);
}

TEST_F(StabilityOfBackprojection, ElevenBitsWithoutASignTakeTwoPassesAndReportWhatTheyClip) {
  const ConeGeometry geometry = small_scan(32, 60);
  const Phantom head = high_contrast_shepp_logan(42);
  const Projections views = project(head, geometry);
  load_fog(board_, {32, 32, 32}, 0);
  HostRay ray = ray_between(0, {1, 4, 4}, {20, 4, 4});
  ray.energy = -1;
  board_.clear_irradiance(0.01);
  EXPECT_THROWS(BadArgument, "energy: expected 0..",
                board_.submit(std::span(&ray, 1), {.type = RayType::kBackproject, .words = SumWords::kIrradiance}));

  const double sums = error(geometry, fdk(geometry, views).values, head).rmse;
  FdkSettings words{.accumulator = Accumulator::kIrradiance, .read_every = 8};
  const Reconstruction fits = fdk(geometry, views, words);
  EXPECT_EQ(fits.clipped, 0);
  const double fine = error(geometry, fits.values, head).rmse;
  EXPECT_LT(fine, 1.2 * sums);
  words.headroom = 0.1;
  const Reconstruction full = fdk(geometry, views, words);
  EXPECT_GT(full.clipped, 0.01);
  EXPECT_GT(error(geometry, full.values, head).rmse, 1.15 * fine);
  record("rmse_clipped", error(geometry, full.values, head).rmse);
  record("rmse_sums", sums);
  record("rmse_11_bits_two_passes", fine);
  record("share_clipped_at_a_tenth_of_the_headroom", full.clipped);
}

// Discs one above the other (Defrise): beyond 20 degrees from the middle plane the method itself loses them; the board
// adds nothing to that.
TEST_F(StabilityOfBackprojection, AWideConeFailsAsMuchAsInDoublePrecision) {
  ConeGeometry geometry = small_scan(48, 60);
  geometry.source_to_axis = 100;
  geometry.source_to_detector = 200;
  geometry.detector = {64, 64, 260.0 / 64, 260.0 / 64};
  Phantom discs;
  for (int i = -3; i <= 3; ++i) discs.push_back({1, {24, 24, 3}, {0, 0, 12.0 * i}, 0});
  const Projections views = project(discs, geometry);
  const std::vector<float> values = fdk(geometry, views).values;
  const std::vector<double> exact = reference::reconstruct(geometry, views);
  // Of the discs' middles: what is left of a disc's value at 0, and at 36 / (100 - 12): 22 degrees.
  const auto contrast = [&](const auto& volume, int disc) {
    const Vec3 at = to_voxels(geometry.volume, {0, 0, 12.0 * disc}),
               gap = to_voxels(geometry.volume, {0, 0, 12.0 * disc - 6});
    const auto mean = [&](double z) {
      double sum = 0;
      for (int y = 20; y < 28; ++y) {
        for (int x = 20; x < 28; ++x)
          sum += static_cast<double>(volume[static_cast<std::size_t>(x + 48 * (y + 48 * std::lround(z)))]) / 64;
      }
      return sum;
    };
    return mean(at.z) - mean(gap.z);
  };
  const double middle = contrast(values, 0), outer = contrast(values, 3);
  const double exact_middle = contrast(exact, 0), exact_outer = contrast(exact, 3);
  EXPECT_LT(exact_outer, 0.5 * exact_middle);
  EXPECT_NEAR(outer / middle, exact_outer / exact_middle, 0.1);
  EXPECT_NEAR(middle, exact_middle, 0.2);  // sharpened: FdkSettings::sharpen
  record("contrast_of_the_disc_in_the_middle_plane", middle);
  record("contrast_of_the_disc_at_20_degrees", outer);
  record("contrast_of_the_disc_at_20_degrees_in_double_precision", exact_outer);
}

TEST_F(StabilityOfBackprojection, ATruncatedDetectorBiasesFilteredMoreThanAlgebraicReconstruction) {
  ConeGeometry whole = small_scan(32, 60);
  const Phantom ball = uniform_sphere(38, 1);
  ConeGeometry cut = whole;
  cut.detector = {16, 32, 100.0 / 16, 200.0 / 32};  // of the ball's 80 units 50 are seen
  const auto bias = [&](const ConeGeometry& geometry, const std::vector<float>& values) {
    return error(geometry, values, ball, 20, 10).bias;
  };
  const Projections cut_views = project(ball, cut);
  const double seen = bias(whole, fdk(whole, project(ball, whole)).values);
  const double filtered = bias(cut, fdk(cut, cut_views).values);
  const double algebraic = bias(cut, sart(cut, cut_views, 0.5).values);
  EXPECT_LT(std::abs(seen), 0.03);
  EXPECT_GT(std::abs(filtered), 0.15);
  EXPECT_LT(std::abs(algebraic), std::abs(filtered));
  record("bias_of_a_ball_seen_whole", seen);
  record("bias_of_a_truncated_ball_fdk", filtered);
  record("bias_of_a_truncated_ball_sart", algebraic);
}

// Two dense balls beside the field that is looked at, which lies in an even ball: what is not even there are streaks.
TEST_F(StabilityOfBackprojection, FewViewsMakeStreaksThatAlgebraicMethodsLessen) {
  const Phantom balls{{1, {40, 40, 40}, {}, 0}, {4, {4, 4, 4}, {31, 0, 0}, 0}, {4, {4, 4, 4}, {0, -31, 0}, 0}};
  const auto streaks = [&](int views, bool algebraic) {
    const ConeGeometry geometry = small_scan(32, views);
    const Projections seen = project(balls, geometry);
    const auto made = algebraic ? sart(geometry, seen, 0.5) : fdk(geometry, seen);
    return error(geometry, made.values, balls, 22, 10).rmse;
  };
  const double few = streaks(10, false), some = streaks(20, false), many = streaks(80, false);
  EXPECT_GT(few, 1.5 * some);
  EXPECT_GT(some, 1.5 * many);
  const double few_algebraic = streaks(10, true);
  EXPECT_LT(few_algebraic, 0.7 * few);
  record("streaks_fdk_10_views", few);
  record("streaks_fdk_20_views", some);
  record("streaks_fdk_80_views", many);
  record("streaks_sart_10_views", few_algebraic);
}

// What noise adds, as the difference of two reconstructions of the same views: its variance falls with the photons.
TEST_F(StabilityOfBackprojection, NoiseFallsWithTheRootOfThePhotonsAndAWindowLessensIt) {
  const ConeGeometry geometry = small_scan(32, 60);
  const Phantom ball = uniform_sphere(36, 0.02);
  const Projections clean = project(ball, geometry);
  const auto noise = [&](double photons, Window window) {
    Projections noisy = clean;
    EXPECT_EQ(add_poisson_noise(noisy, photons, 3), 0u);
    const std::vector<float> with = fdk(geometry, noisy, {.window = window}).values,
                             without = fdk(geometry, clean, {.window = window}).values;
    return compare(geometry.volume, with, without, {30, 20}).rmse;
  };
  const double few = noise(1e3, Window::kRamLak), many = noise(1e5, Window::kRamLak);
  EXPECT_NEAR(few / many, 10, 1);
  EXPECT_LT(noise(1e3, Window::kHann), 0.7 * few);
  record("noise_of_1e3_photons", few);
  record("noise_of_1e5_photons", many);
}

TEST_F(StabilityOfBackprojection, TooMuchRelaxationDivergesIsDetectedAndBringsBackTheBest) {
  const ConeGeometry geometry = small_scan(24, 24);
  const Phantom head = high_contrast_shepp_logan(42);
  const Projections views = project(head, geometry);
  const Reconstruction good = sart(geometry, views, 0.5, 8);
  EXPECT_FALSE(good.diverged);
  EXPECT_LT(good.residuals.back(), 0.5 * good.residuals.front());
  const std::vector<float> nothing(good.values.size());
  for (const double relaxation : {2.5, 4.0}) {
    const Reconstruction bad = sart(geometry, views, relaxation, 30);
    EXPECT_TRUE(bad.diverged) << relaxation;
    EXPECT_LT(bad.residuals.size(), 30u);
    EXPECT_LE(error(geometry, bad.values, head).rmse, error(geometry, nothing, head).rmse);
    if (relaxation == 2.5)
      record("iterations_until_divergence_is_seen_at_2.5", static_cast<double>(bad.residuals.size()));
  }
  record("residual_after_8_iterations_at_0.5", good.residuals.back());
}

}  // namespace
}  // namespace gicube::stability
