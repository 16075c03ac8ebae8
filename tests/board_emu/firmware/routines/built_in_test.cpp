// The built-in routines against closed forms.
#include "firmware/routines/built_in.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "words/vectors.h"

namespace gicube::emu {
namespace {

using testing::HasSubstr;
using testing::Optional;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// `count` events at random, as the board draws their numbers.
template <typename Take>
void draw(const BuiltIn& routine, ScatterEvent event, int count, const Take& take) {
  std::mt19937 random(7);
  for (int i = 0; i < count; ++i) {
    for (double& number : event.random) number = static_cast<double>(random()) * 0x1p-32;
    const ScatterAnswer answer = routine.scatter(event);
    ASSERT_NEAR(dot(answer.direction, answer.direction), 1, 1e-9);
    take(answer.direction);
  }
}

ScatterEvent falling(double angle, bool from_inside = false) {  // onto the surface z = 0, whose outside is up
  ScatterEvent event;
  event.normal = {0, 0, 1};
  event.direction = {std::sin(angle), 0, from_inside ? std::cos(angle) : -std::cos(angle)};
  return event;
}

constexpr double kDegree = std::numbers::pi / 180;

TEST(Fresnel, ReflectsAtNormalIncidenceAsItsClosedFormSays) {
  for (const double n : {1.1, 1.33, 1.5, 2.42}) {
    const double expected = std::pow((n - 1) / (n + 1), 2);
    EXPECT_NEAR(fresnel_reflectance(1, 1, n), expected, 1e-12);
    EXPECT_NEAR(fresnel_reflectance(1, n, 1), expected, 1e-12);
  }
  EXPECT_EQ(fresnel_reflectance(0, 1, 1.5), 1) << "grazing";
}

TEST(Fresnel, LosesOnePolarisationAtBrewstersAngle) {
  constexpr double kIndex = 1.5;
  const double cosine = std::cos(std::atan(kIndex));  // where only the light across the plane of incidence is reflected
  const double across = (kIndex * kIndex - 1) / (kIndex * kIndex + 1);
  EXPECT_NEAR(fresnel_reflectance(cosine, 1, kIndex), across * across / 2, 1e-12);
}

// Diffuse light on glass of index 1.5: 9.178% (Judd, Fresnel Reflection of Diffusely Incident Light, 1942).
TEST(Fresnel, ReflectsDiffuseLightAsInJuddsTable) {
  double sum = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) sum += fresnel_reflectance(std::sqrt((i + 0.5) / kSteps), 1, 1.5) / kSteps;
  EXPECT_NEAR(sum, 0.09178, 2e-5);
}

TEST(Fresnel, DrawsMirrorAndRefractionWithTheirProbabilities) {
  const float index = 1.5f;
  for (const double angle : {0.0, 30 * kDegree, 60 * kDegree, 80 * kDegree}) {
    ScatterEvent event = falling(angle);
    event.parameters = std::span(&index, 1);
    constexpr int kCount = 20000;
    int reflected = 0;
    draw(kFresnel, event, kCount, [&](const Vector& out) {
      const double expected = out[2] > 0 ? std::sin(angle) : std::sin(angle) / index;  // mirror; Snell
      EXPECT_NEAR(std::hypot(out[0], out[1]), expected, 1e-9);
      EXPECT_GE(out[0], 0);
      reflected += out[2] > 0;
    });
    const double share = fresnel_reflectance(std::cos(angle), 1, index);
    EXPECT_NEAR(reflected, kCount * share, 4 * std::sqrt(kCount * share * (1 - share)));
  }
}

TEST(Fresnel, BendsARayThatLeavesAndKeepsItBeyondTheCriticalAngle) {
  const float index = 1.5f;  // critical angle 41.8 degrees
  ScatterEvent event = falling(30 * kDegree, true);
  event.parameters = std::span(&index, 1);
  event.random[0] = 0.999;
  const Vector out = kFresnel.scatter(event).direction;
  EXPECT_NEAR(out[0], 1.5 * std::sin(30 * kDegree), 1e-9);
  EXPECT_GT(out[2], 0);

  event.direction = falling(42 * kDegree, true).direction;
  const Vector kept = kFresnel.scatter(event).direction;
  EXPECT_NEAR(kept[0], std::sin(42 * kDegree), 1e-12);
  EXPECT_NEAR(kept[2], -std::cos(42 * kDegree), 1e-12);
}

TEST(Fresnel, LetsARayPassWhereThereIsNoSurface) {
  const float none = 1;
  ScatterEvent event = falling(50 * kDegree);
  event.parameters = std::span(&none, 1);
  EXPECT_NEAR(dot(kFresnel.scatter(event).direction, event.direction), 1, 1e-12) << "index 1";
  event.parameters = {};
  event.normal = {};
  EXPECT_EQ(kFresnel.scatter(event).direction, event.direction) << "no gradient";
}

TEST(HenyeyGreenstein, HasTheMeanCosineG) {
  for (const float g : {-0.9f, -0.3f, 0.0f, 1e-5f, 0.5f, 0.95f}) {
    ScatterEvent event;
    event.direction = {0.6, 0, -0.8};
    event.parameters = std::span(&g, 1);
    constexpr int kCount = 40000;
    double sum = 0, squares = 0;
    Vector across{};
    draw(kHenyeyGreenstein, event, kCount, [&](const Vector& out) {
      const double cosine = dot(out, event.direction);
      sum += cosine;
      squares += cosine * cosine;
      across = along(across, 1, along(out, -cosine, event.direction));
    });
    const double mean = sum / kCount, deviation = std::sqrt((squares / kCount - mean * mean) / kCount);
    EXPECT_NEAR(mean, g, 4 * deviation) << g;
    EXPECT_NEAR(squares / kCount, (1 + 2 * double{g} * g) / 3, 0.01) << g;
    EXPECT_LT(std::sqrt(dot(across, across)) / kCount, 0.02) << "even about the axis, g = " << g;
  }
}

// A histogram of cosines against the integral of the table.
TEST(TabulatedPhaseFunction, IsDrawnAsItsTableSays) {
  const std::vector<std::vector<float>> tables{
      {3}, {0, 1}, {2, 0.5f, 1}, {0, 0, 5, 0, 0}, {1, 0, 0, 1}, {1, 2, 3, 2, 8, 0.25f, 0}};
  for (const auto& table : tables) {
    SCOPED_TRACE(testing::PrintToString(table));
    ASSERT_FALSE(kTabulated.fault(table));
    const auto value = [&](double cosine) {
      if (table.size() == 1) return double{table[0]};
      const double at = (cosine + 1) / 2 * static_cast<double>(table.size() - 1);
      const auto i = std::min(static_cast<std::size_t>(at), table.size() - 2);
      return table[i] + (at - static_cast<double>(i)) * (table[i + 1] - table[i]);
    };
    constexpr int kBins = 24, kCount = 60000, kFine = 400;
    std::vector<double> expected(kBins), drawn(kBins);
    double all = 0;
    for (int i = 0; i < kBins * kFine; ++i) {
      const double weight = value(2 * (i + 0.5) / (kBins * kFine) - 1);
      expected[static_cast<std::size_t>(i / kFine)] += weight;
      all += weight;
    }
    ScatterEvent event;
    event.direction = {0, 0.6, 0.8};
    event.parameters = table;
    draw(kTabulated, event, kCount, [&](const Vector& out) {
      const double bin = std::floor((dot(out, event.direction) + 1) / 2 * kBins);
      ++drawn[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))];
    });
    for (std::size_t bin = 0; bin < kBins; ++bin) {
      const double mean = kCount * expected[bin] / all;
      EXPECT_NEAR(drawn[bin], mean, 4.5 * std::sqrt(mean) + 0.01 * mean + 0.5) << bin;
    }
  }
}

TEST(TabulatedPhaseFunction, TakesTheEndsOfChance) {
  const std::vector<float> table{0, 0, 5, 0, 0};
  ScatterEvent event;
  event.direction = {1, 0, 0};
  event.parameters = table;
  EXPECT_NEAR(kTabulated.scatter(event).direction[0], -0.5, 1e-9);
  event.random[0] = 1 - 0x1p-53;
  EXPECT_NEAR(kTabulated.scatter(event).direction[0], 0.5, 1e-6);
}

TEST(BuiltInRoutines, RefuseParametersByName) {
  const auto fault = [](const BuiltIn& routine, std::vector<float> parameters) { return routine.fault(parameters); };
  EXPECT_FALSE(fault(kFresnel, {}));
  EXPECT_FALSE(fault(kFresnel, {1.33f}));
  EXPECT_THAT(fault(kFresnel, {0}), Optional(HasSubstr("index of refraction: expected 0.01..100, got 0.0")));
  EXPECT_THAT(fault(kFresnel, {kNan}), Optional(HasSubstr("index of refraction")));
  EXPECT_THAT(fault(kFresnel, {1, 2}), Optional(HasSubstr("expected 1 parameter, got 2")));
  EXPECT_FALSE(fault(kHenyeyGreenstein, {-0.99f}));
  EXPECT_THAT(fault(kHenyeyGreenstein, {1}), Optional(HasSubstr("g: expected")));
  EXPECT_THAT(fault(kHenyeyGreenstein, {kNan}), Optional(HasSubstr("g: expected")));
  EXPECT_THAT(fault(kTabulated, {}), Optional(HasSubstr("got none")));
  EXPECT_THAT(fault(kTabulated, {1, -2}), Optional(HasSubstr("got -2")));
  EXPECT_THAT(fault(kTabulated, {1, kNan}), Optional(HasSubstr("got nan")));
  EXPECT_THAT(fault(kTabulated, {0, 0}), Optional(HasSubstr("only zeros")));
}

}  // namespace
}  // namespace gicube::emu
