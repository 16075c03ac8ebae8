#include "cone_beam/phantom/phantom.h"

#include "../small_scan.h"
#include "test.h"

namespace gicube::samples {
namespace {

double march(const Phantom& phantom, Vec3 from, Vec3 to) {
  constexpr int kSteps = 200'000;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) sum += value_at(phantom, from + ((i + 0.5) / kSteps) * (to - from));
  return sum * length(to - from) / kSteps;
}

TEST(Phantom, ASpheresLineIntegralsAreItsChords) {
  const Phantom sphere = uniform_sphere(3, 2);
  EXPECT_NEAR(line_integral(sphere, {-10, 0, 0}, {10, 0, 0}), 2 * 6, 1e-12);
  EXPECT_NEAR(line_integral(sphere, {-10, 0, 2}, {20, 0, 2}), 2 * 2 * std::sqrt(5.0), 1e-12);
  EXPECT_EQ(line_integral(sphere, {-10, 3.01, 0}, {10, 3.01, 0}), 0);
}

TEST(Phantom, TheHeadsLineIntegralsAreThoseOfItsValues) {
  for (const Phantom& head : {shepp_logan(10), high_contrast_shepp_logan(10)}) {
    for (const auto& [from, to] : {std::pair(Vec3{-20, 3, -2}, Vec3{18, -2, -3}),
                                   {{-2, -30, -2.6}, {-2.3, 25, -2.4}},
                                   {{1, 1, -30}, {0.2, 0.5, 31}}}) {
      EXPECT_NEAR(line_integral(head, from, to), march(head, from, to), 2e-3);
    }
  }
}

TEST(Phantom, TheHeadHasTheTablesValues) {
  const Phantom head = shepp_logan(1), contrasts = high_contrast_shepp_logan(1);
  EXPECT_NEAR(value_at(head, {0, -0.9, 0}), 2, 1e-12);         // skull
  EXPECT_NEAR(value_at(head, {0, -0.8, 0}), 1.02, 1e-12);      // brain
  EXPECT_NEAR(value_at(head, {0, 0.35, -0.25}), 1.04, 1e-12);  // the large ellipsoid in front
  EXPECT_NEAR(value_at(head, {-0.22, 0, -0.25}), 1.0, 1e-12);  // a ventricle, turned by 108 degrees
  EXPECT_NEAR(value_at(head, {-0.30, 0.25, -0.25}), 1.0, 1e-12);
  EXPECT_NEAR(value_at(head, {-0.30, -0.25, -0.25}), 1.02, 1e-12);
  EXPECT_NEAR(value_at(contrasts, {0, 0.1, 0.625}), 0.0, 1e-12);
  EXPECT_NEAR(value_at(contrasts, {0, -0.8, 0}), 0.2, 1e-12);
}

TEST(Phantom, DiscsAreFlatAndEquallyFarApart) {
  const Phantom seven = discs(36);
  for (int disc = -4; disc <= 4; ++disc) {
    const double inside = std::abs(disc) <= 3 ? 1 : 0;
    EXPECT_EQ(value_at(seven, {0, 0, 11.0 * disc + 1.99}), inside) << disc;
    EXPECT_EQ(value_at(seven, {25, 25, 11.0 * disc}), inside) << disc;
    EXPECT_EQ(value_at(seven, {0, 0, 11.0 * disc + 2.01}), 0) << disc;
  }
  EXPECT_EQ(value_at(seven, {36.1, 0, 0}), 0);
}

TEST(Phantom, ProjectionsAndVoxelsLieWhereTheGeometrySays) {
  ConeGeometry geometry = small_scan(40, 4);
  geometry.angles = even_angles(4, 0, 2 * std::numbers::pi);
  const Phantom ball{{1, {5, 5, 5}, {20, 0, 10}, 0}};  // towards the first view's source, and up
  const Projections views = project(ball, geometry);
  const auto brightest = [&](std::size_t view) {
    std::size_t best = 0;
    for (std::size_t i = 0; i < views.view_size(); ++i) {
      if (views.view(view)[i] > views.view(view)[best]) best = i;
    }
    const std::size_t row = best / 40;
    return std::pair(u_of(geometry.detector, static_cast<double>(best % 40)),
                     v_of(geometry.detector, static_cast<double>(row)));
  };
  EXPECT_NEAR(brightest(0).first, 0, 5);
  EXPECT_NEAR(brightest(0).second, 10 * 800 / 380.0, 5);
  // A quarter turn later the ball lies at x = 20, and columns run along -x.
  EXPECT_NEAR(brightest(1).first, -20 * 2, 5);
  EXPECT_NEAR(brightest(2).second, 10 * 800 / 420.0, 5);
  const std::vector<float> values = voxels(ball, geometry.volume);
  const Vec3 at = to_voxels(geometry.volume, {20, 0, 10});
  const auto index = static_cast<std::size_t>(std::lround(at.x) + 40 * (std::lround(at.y) + 40 * std::lround(at.z)));
  EXPECT_EQ(values[index], 1);
  EXPECT_EQ(values[0], 0);
}

}  // namespace
}  // namespace gicube::samples
