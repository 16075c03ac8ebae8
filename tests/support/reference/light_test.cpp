#include "light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gicube::reference {
namespace {

constexpr double kExact = 1e-12;

Light make(const Phong& phong, Vec3 light, Vec3 towards_eye) { return Light({phong, light}, towards_eye, {}); }

TEST(Light, OfNoDirectionStandsAtTheEye) {
  const Light light = make({0.1, 0.5, 0.25, 8}, {}, {0, 1, 0});
  EXPECT_NEAR(light.reflected({0, 1, 0}), 0.75, kExact);
}

TEST(Light, ReflectsByLambertsCosineAndNothingFromBehind) {
  const Light light = make({0, 1, 0, 1}, {0, 0, 9}, {1, 0, 0});
  for (const double angle : {0.0, 0.5, 1.5})
    EXPECT_NEAR(light.reflected({std::sin(angle), 0, std::cos(angle)}), std::cos(angle), kExact);
  EXPECT_EQ(light.reflected({std::sin(2.0), 0, std::cos(2.0)}), 0);
}

TEST(Light, HasItsHighlightInTheMirrorDirection) {
  // Light 45 degrees to one side of the normal, eye 45 degrees to the other.
  const Light light = make({0, 0, 1, 50}, {1, 0, 1}, normalise({-1, 0, 1}));
  EXPECT_NEAR(light.reflected({0, 0, 1}), 1, kExact);
  // The normal turned by 0.1: the mirrored light turns by 0.2.
  EXPECT_NEAR(light.reflected({std::sin(0.1), 0, std::cos(0.1)}), std::pow(std::cos(0.2), 50), kExact);
}

TEST(Light, FadesTheHighlightInAtTheTerminator) {
  // N.L = 0.05, mirrored into the eye: half of the highlight.
  const double angle = std::acos(0.05);
  const Light light = make({0, 0, 1, 5}, {std::sin(angle), 0, std::cos(angle)}, {-std::sin(angle), 0, std::cos(angle)});
  EXPECT_NEAR(light.reflected({0, 0, 1}), 0.5, kExact);
}

TEST(Light, SendsWhatIsAboveTheKneeToWhite) {
  const Light light = make({0.2, 0.6, 0.4, 3}, {}, {0, 0, 1});
  const auto lit = light.shade({0.5, 0, 1}, {0, 0, -2});
  EXPECT_NEAR(lit[0], 0.5 * 0.8 + 0.4, kExact);
  EXPECT_NEAR(lit[1], 0.4, kExact);
  EXPECT_EQ(lit[2], 1);  // held
}

TEST(Light, LeavesSamplesOfShortGradientAlone) {
  const Light light = make({0.2, 0.6, 0, 1}, {}, {0, 0, 1});
  EXPECT_EQ(light.shade({1, 1, 1}, {0, 0, 0.0624})[0], 1);
  EXPECT_NEAR(light.shade({1, 1, 1}, {0, 0, 0.0626})[0], 0.2, kExact);
}

TEST(ReflectanceMap, IsWithinItsTexelsOfTheExactReflectance) {
  const Shading shading{{0.2, 0.7, 0.3, 16}, {1, 2, 3}};
  const Vec3 eye = normalise({1, 0.2, 1});
  Quantisers quantisers;
  quantisers.reflectance = true;
  const Light exact(shading, eye, {}), mapped(shading, eye, quantisers);
  double worst = 0;
  for (int i = 0; i < 5000; ++i) {
    // A spiral over the sphere of normals.
    const double z = 1 - (2 * i + 1) / 5000.0, angle = 2.399963 * i, r = std::sqrt(1 - z * z);
    const Vec3 gradient{-r * std::cos(angle), -r * std::sin(angle), -z};
    worst = std::max(worst, std::abs(exact.shade({1, 0, 0}, gradient)[0] - mapped.shade({1, 0, 0}, gradient)[0]));
  }
  EXPECT_LT(worst, 0.015);   // half a unit of the map and of two coefficients is 0.012
  EXPECT_GT(worst, 0.0005);  // the map is in use
}

}  // namespace
}  // namespace gicube::reference
