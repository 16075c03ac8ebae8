#include "cone_beam/fdk.h"

#include "cone_beam/phantom/phantom.h"
#include "reference/fdk.h"
#include "small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

using std::numbers::pi;

TEST(RampFilter, ADiscsProjectionBecomesFlat) {
  std::vector<double> row(300), out(300);
  for (int i = 0; i < 300; ++i) {
    const double u = (i - 149.5) * 0.5;
    row[static_cast<std::size_t>(i)] = 2 * std::sqrt(std::max(0.0, 2500 - u * u));
  }
  for (const Window window : {Window::kRamLak, Window::kSheppLogan, Window::kHann}) {
    const RampFilter filter(300, 0.5, window);
    filter.apply(row.data(), out.data());
    for (std::size_t i = 110; i < 190; ++i) EXPECT_NEAR(out[i], 1 / pi, 0.004 / pi);
    EXPECT_LT(out[10], 0);
  }
}

TEST(RampFilter, IsTheConvolutionWithItsKernel) {
  const ConeGeometry geometry = small_scan(64, 8);
  const Projections views = project(high_contrast_shepp_logan(40), geometry);
  const double pitch = geometry.detector.pitch_u / 2;
  for (const auto& [window, kernel] :
       {std::pair(Window::kRamLak, reference::Kernel::kRamLak), {Window::kHann, reference::Kernel::kHann}}) {
    const RampFilter filter(64, pitch, window);
    const auto expected = reference::filter_rows(geometry, views, 3, kernel);
    std::vector<double> row(64), out(64);
    for (const std::size_t j : {20u, 31u}) {
      const double v = v_of(geometry.detector, static_cast<double>(j));
      for (std::size_t i = 0; i < 64; ++i) {
        const double u = u_of(geometry.detector, static_cast<double>(i));
        row[i] = static_cast<double>(views.view(3)[j * 64 + i]) * 800 / std::sqrt(800 * 800 + u * u + v * v) / 2;
      }
      filter.apply(row.data(), out.data());
      for (std::size_t i = 0; i < 64; ++i) EXPECT_NEAR(out[i], expected[j * 64 + i], 1e-3) << i;
    }
  }
}

TEST(ArcWeights, SumToHalfATurn) {
  const auto sum = [](const ConeGeometry& geometry) {
    const auto weights = arc_weights(geometry);
    return std::accumulate(weights.begin(), weights.end(), 0.0);
  };
  EXPECT_NEAR(sum(small_scan(16, 90)), pi, 1e-12);
  EXPECT_NEAR(sum(small_scan(16, 90, pi + 0.5)), pi + 0.5, 1e-12);  // shared out by short_scan_weight()
  ConeGeometry uneven = small_scan(16, 4);
  uneven.angles = {0, 0.1, 3, 5};
  EXPECT_NEAR(sum(uneven), pi, 1e-12);
  EXPECT_FALSE(is_short_scan(small_scan(16, 90)));
  EXPECT_TRUE(is_short_scan(small_scan(16, 90, pi + 0.5)));
}

TEST(ShortScanWeights, OfARayThatIsMeasuredTwiceSumToOne) {
  constexpr double kMax = 0.2, kArc = pi + 2 * kMax;
  for (const double fan : {-0.2, -0.13, 0.0, 0.05, 0.199}) {
    for (double angle = 0; angle <= kArc; angle += 0.01) {
      double weight = short_scan_weight(angle, fan, kArc);
      for (const double other : {angle + pi + 2 * fan, angle - pi + 2 * fan}) {
        if (other >= 0 && other <= kArc) weight += short_scan_weight(other, -fan, kArc);
      }
      EXPECT_NEAR(weight, 1, 1e-9) << angle << ' ' << fan;
    }
  }
}

}  // namespace
}  // namespace gicube::samples
