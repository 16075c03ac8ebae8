#include "fdk.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cone_beam/phantom/phantom.h"

namespace gicube::reference {
namespace {

using namespace samples;
using std::numbers::pi;

ConeGeometry small(int size, int views, double arc) {
  ConeGeometry geometry;
  geometry.source_to_axis = 500;
  geometry.source_to_detector = 1000;
  geometry.detector = {size, size, 2 * 100.0 / size, 2 * 100.0 / size};
  geometry.volume = {{size, size, size}, (84.0 / size) * Vec3{1, 1, 1}};
  geometry.angles = even_angles(views, 0.3, arc);
  return geometry;
}

TEST(FdkReference, FilteredDiscsAreFlatAsParallelBeamsWouldHaveThem) {
  // Far away the beam is parallel: of a disc's projection 2 sqrt(r^2 - u^2) the ramp leaves 1 / pi inside, here times
  // one half.
  ConeGeometry geometry = small(400, 2, 2 * pi);
  geometry.detector.rows = 1;
  geometry.source_to_axis = geometry.source_to_detector = 1e9;
  Projections disc{400, 1, std::vector<float>(800)};
  for (std::size_t i = 0; i < 400; ++i) {
    const double u = u_of(geometry.detector, static_cast<double>(i));
    disc.values[i] = static_cast<float>(2 * std::sqrt(std::max(0.0, 3600 - u * u)));
  }
  for (const Kernel kernel : {Kernel::kRamLak, Kernel::kSheppLogan, Kernel::kHann}) {
    const auto filtered = filter_rows(geometry, disc, 0, kernel);
    for (std::size_t i = 150; i < 250; ++i) EXPECT_NEAR(filtered[i] * 2, 1 / pi, 0.004 / pi) << i;
    EXPECT_LT(filtered[20], 0);
  }
}

TEST(FdkReference, AUniformSphereHasItsValueAndNothingAroundIt) {
  const ConeGeometry geometry = small(48, 72, 2 * pi);
  const auto values = reconstruct(geometry, project(uniform_sphere(30, 0.8), geometry));
  std::vector<double> sphere(values.size(), 0.8), empty(values.size());
  // Within the middle plane, where the method is exact but for its sampling.
  EXPECT_NEAR(difference(geometry.volume, values, sphere, 22, 3).bias, 0, 0.008 * 0.8);
  EXPECT_NEAR(difference(geometry.volume, values, sphere, 22, 3).rmse, 0, 0.02 * 0.8);
  double outside = 0;
  for (int x = 0; x < 3; ++x) outside += values[static_cast<std::size_t>(x + 48 * (24 + 48 * 24))] / 3;
  EXPECT_NEAR(outside, 0, 0.02);
}

TEST(FdkReference, AShortScanGivesWhatAWholeTurnDoes) {
  const ConeGeometry whole = small(48, 144, 2 * pi);
  const double fan = std::atan(100.0 / 1000);
  const ConeGeometry part = small(48, 90, pi + 2 * fan);
  const Phantom head = high_contrast_shepp_logan(40);
  const auto one = reconstruct(whole, project(head, whole)), other = reconstruct(part, project(head, part));
  const Difference off = difference(whole.volume, other, one, 35, 3);
  EXPECT_LT(off.rmse, 0.03);
  EXPECT_NEAR(off.bias, 0, 0.003);
}

}  // namespace
}  // namespace gicube::reference
