// Irradiance on a small surface against closed forms, and samples against what rays find.
#include "light_samples.h"

#include <numbers>

#include "path_tests.h"

namespace gicube::reference::paths {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kSamples = 40000;

// Of a surface at `place` of this normal.
Estimate irradiance(const Light& light, Vec3 place, Vec3 normal, std::uint64_t seed) {
  CounterRandom random(seed, 0);
  double sum = 0, squares = 0;
  for (int i = 0; i < kSamples; ++i) {
    const LightSample sample = sample_light(light, place, random);
    const double one = sample.weight * std::max(0.0, dot(normal, sample.direction));
    sum += one, squares += one * one;
  }
  const double mean = sum / kSamples;
  return {mean, std::sqrt(std::max(0.0, squares / kSamples - mean * mean) / kSamples)};
}

TEST(Lights, OfAPointAndASphereLightAlikeFromEverywhereOutside) {
  for (const double distance : {2.5, 10.0}) {
    const double truth = 7 / (4 * kPi * distance * distance);
    expect_near(irradiance(PointLight{{1, 2, 3 + distance}, 7}, {1, 2, 3}, kAhead, 1), truth, "point");
    expect_near(irradiance(SphereLight{{1, 2, 3 + distance}, 2, 7}, {1, 2, 3}, kAhead, 2), truth, "sphere");
  }
  EXPECT_EQ(irradiance(SphereLight{{0, 0, 1}, 2, 7}, {0, 0, 0}, kAhead, 3).mean, 0);  // within
}

TEST(Lights, OfARectangleLightAParallelSurfaceByItsFormFactor) {
  // 6 x 4 above the middle, at 5: four times that of a rectangle above a corner.
  const RectangleLight light{{-3, -2, 5}, {0, 4, 0}, {6, 0, 0}, 9};
  const double a = 3.0 / 5, b = 2.0 / 5;
  const double corner = (a / std::hypot(1, a) * std::atan(b / std::hypot(1, a)) +
                         b / std::hypot(1, b) * std::atan(a / std::hypot(1, b))) /
                        (2 * kPi);
  expect_near(irradiance(light, {}, kAhead, 4), 9 / 24.0 * 4 * corner, "in front");
  EXPECT_EQ(irradiance(light, {0, 0, 10}, {0, 0, -1}, 5).mean, 0) << "behind";
}

// Rays in all directions, each with the radiance that it finds.
TEST(Lights, HaveTheRadianceThatTheirSamplesSay) {
  const std::vector<Light> lights{RectangleLight{{-3, -2, 5}, {0, 4, 0}, {6, 1, 2}, 9}, SphereLight{{1, 2, 4}, 2, 7}};
  for (const Light& light : lights) {
    CounterRandom random(6, 0);
    double sum = 0, squares = 0;
    for (int i = 0; i < kSamples; ++i) {
      const Vec3 direction = random.direction();
      const auto hit = hit_light(light, {}, direction);
      const double one = hit ? 4 * kPi * hit->radiance * std::max(0.0, direction.z) : 0;
      sum += one, squares += one * one;
    }
    const double mean = sum / kSamples, error = std::sqrt((squares / kSamples - mean * mean) / kSamples);
    const Estimate sampled = irradiance(light, {}, kAhead, 7);
    expect_near({mean, std::hypot(error, sampled.error)}, sampled.mean, "radiance");
  }
}

TEST(Lights, AreFoundWhereTheyAre) {
  const auto rectangle = hit_light(RectangleLight{{-1, -1, 5}, {0, 2, 0}, {2, 0, 0}, 1}, {}, kAhead);
  ASSERT_TRUE(rectangle);
  EXPECT_NEAR(rectangle->distance, 5, 1e-12);
  EXPECT_FALSE(hit_light(RectangleLight{{-1, -1, 5}, {0, 2, 0}, {2, 0, 0}, 1}, {3, 0, 0}, kAhead));
  EXPECT_FALSE(hit_light(RectangleLight{{-1, -1, 5}, {2, 0, 0}, {0, 2, 0}, 1}, {}, kAhead));  // shines away
  const auto sphere = hit_light(SphereLight{{0, 0, 5}, 2, 1}, {}, kAhead);
  ASSERT_TRUE(sphere);
  EXPECT_NEAR(sphere->distance, 3, 1e-12);
  EXPECT_FALSE(hit_light(SphereLight{{0, 0, 5}, 2, 1}, {0, 0, 4}, kAhead));  // from within
  EXPECT_FALSE(hit_light(PointLight{{0, 0, 5}, 1}, {}, kAhead));
}

}  // namespace
}  // namespace gicube::reference::paths
