#include "gicube/scene/hypertexture.h"

#include "gicube/scene/error.h"
#include "gicube/scene/voxeliser.h"
#include "test.h"

namespace gicube::scene {
namespace {

using Kind = HypertextureKind;

std::vector<Vec3> random_points(double most, int count = 2000) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> place(-most, most);
  std::vector<Vec3> points;
  for (int i = 0; i < count; ++i) points.push_back({place(engine), place(engine), place(engine)});
  return points;
}

double ramp(double distance, double softness) {
  const double density = 0.5 - distance / softness;
  return density > 0 ? std::min(density, 1.0) : -1;
}

TEST(Hypertexture, WithoutNoiseIsASoftSolid) {
  for (const Kind kind : {Kind::kNoise, Kind::kTurbulence, Kind::kFlame}) {
    const auto density = density_of({.kind = kind, .softness = 0.5, .amplitude = 0, .stretch = 1});
    for (const Vec3& p : random_points(1.5)) ASSERT_NEAR(density(p), ramp(length(p) - 1, 0.5), 1e-12);
  }
}

TEST(Hypertexture, MovesTheSurfaceAtMostByItsAmplitude) {
  const auto noise = density_of({.kind = Kind::kNoise, .softness = 0.01, .amplitude = 0.2});
  const auto cloud = density_of({.kind = Kind::kTurbulence, .softness = 0.01, .octaves = 5, .amplitude = 0.1});
  int inside = 0, outside = 0;
  for (const Vec3& p : random_points(1.3, 20'000)) {
    const double distance = length(p) - 1;
    if (distance < -0.21) {
      ASSERT_EQ(noise(p), 1);
    }
    if (distance > 0.21) {
      ASSERT_EQ(noise(p), -1);
    }
    if (distance < -0.01) {  // outwards only
      ASSERT_EQ(cloud(p), 1);
    }
    if (distance > 0.21) {
      ASSERT_EQ(cloud(p), -1);
    }
    inside += distance < -0.01 && noise(p) < 0 ? 1 : 0;
    outside += distance > 0.01 && noise(p) > 0 ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 100);
}

TEST(Hypertexture, IsTheSameForASeedAndChangesWithTimeContinuously) {
  const Hypertexture texture{.kind = Kind::kTurbulence, .softness = 0.5};
  auto at = [&](std::uint32_t seed, double time) {
    Hypertexture other = texture;
    other.seed = seed, other.time = time;
    return density_of(other);
  };
  const auto first = at(0, 0), same = at(0, 0), other = at(1, 0), soon = at(0, 1e-4), later = at(0, 0.5);
  double by_seed = 0, by_time = 0, at_once = 0;
  for (const Vec3& p : random_points(1.4)) {
    ASSERT_EQ(first(p), same(p));
    if (first(p) < 0 || soon(p) < 0 || later(p) < 0 || other(p) < 0) continue;
    by_seed = std::max(by_seed, std::abs(first(p) - other(p)));
    by_time = std::max(by_time, std::abs(first(p) - later(p)));
    at_once = std::max(at_once, std::abs(first(p) - soon(p)));
  }
  EXPECT_GT(by_seed, 0.1);
  EXPECT_GT(by_time, 0.1);
  EXPECT_LT(at_once, 0.01);
}

TEST(Hypertexture, OfFurHasHairsThatGetThinnerUpToTheirLength) {
  const auto density = density_of({.kind = Kind::kFur, .softness = 0.05, .frequency = 8, .length = 0.4});
  int roots = 0, middles = 0, tips = 0;
  for (const Vec3& p : random_points(1)) {
    const Vec3 out = normalise(p);
    EXPECT_EQ(density(0.99 * out), 1);
    EXPECT_EQ(density(1.41 * out), -1);
    double before = 1;  // along a hair the density only falls
    for (double height = 0.01; height < 0.4; height += 0.03) {
      const double here = density((1 + height) * out);
      ASSERT_LE(here, before + 1e-12);
      before = here;
    }
    roots += density(1.01 * out) > 0 ? 1 : 0;
    middles += density(1.2 * out) > 0 ? 1 : 0;
    tips += density(1.35 * out) > 0 ? 1 : 0;
  }
  EXPECT_GT(roots, middles + 200);
  EXPECT_GT(middles, tips + 200);
}

TEST(Hypertexture, OfFurCurlsTipsMoreThanRoots) {
  const Hypertexture straight{.kind = Kind::kFur, .softness = 0.4, .frequency = 6, .length = 0.4};
  Hypertexture curled = straight;
  curled.curl = 0.2;
  const auto one = density_of(straight), other = density_of(curled);
  double low = 0, high = 0;
  for (const Vec3& p : random_points(1)) {
    const Vec3 out = normalise(p);
    low += std::abs(one(1.02 * out) - other(1.02 * out));
    high += std::abs(std::max(one(1.2 * out), 0.0) - std::max(other(1.2 * out), 0.0));
  }
  EXPECT_LT(low, 0.1 * high);
}

TEST(Hypertexture, OfAFlameIsDrawnOutUpwardsAndTornByRisingNoise) {
  const Hypertexture calm{.kind = Kind::kFlame, .softness = 0.01, .amplitude = 0, .stretch = 4};
  const auto drawn = density_of(calm);
  EXPECT_EQ(drawn({0, 0, 3.9}), 1);
  EXPECT_EQ(drawn({0, 0, 4.1}), -1);
  EXPECT_EQ(drawn({0, 0, -1.1}), -1);
  // What tears the flame at a height now tears it a cell of noise, stretched, higher after a unit of time; more, as it
  // is higher.
  Hypertexture torn = calm;
  torn.softness = 3, torn.amplitude = 0.4, torn.frequency = 5, torn.octaves = 1;
  const auto density = density_of(torn);
  torn.time = 0.5;
  const auto later = density_of(torn);
  double below = 0, moved = 0;
  for (const Vec3& p : random_points(0.8)) {
    below = std::max(below, std::abs(density({p.x, p.y, -0.5}) - later({p.x, p.y, -0.5})));
    moved = std::max(moved, std::abs(density({p.x, p.y, 2}) - later({p.x, p.y, 2})));
  }
  EXPECT_EQ(below, 0);
  EXPECT_GT(moved, 0.01);
}

TEST(Hypertexture, RefusesNumbersWithoutAMeaningByTheirNames) {
  const auto refusal = [](const Hypertexture& texture) -> std::string {
    return message_of<InputError>([&] { check(texture); });
  };
  EXPECT_EQ(refusal({}), "none");
  EXPECT_THAT(refusal({.shape = SphereShape{-1}}), HasSubstr("radius"));
  EXPECT_THAT(refusal({.softness = 0}), HasSubstr("softness: expected a number above 0, got 0"));
  EXPECT_THAT(refusal({.frequency = -1}), HasSubstr("frequency"));
  EXPECT_THAT(refusal({.octaves = 13}), HasSubstr("octaves: expected 1 to 12, got 13"));
  EXPECT_THAT(refusal({.amplitude = -1}), HasSubstr("amplitude: expected a number not below 0, got -1"));
  EXPECT_THAT(refusal({.time = NAN}), HasSubstr("time"));
  EXPECT_THAT(refusal({.length = 0}), HasSubstr("length"));
  EXPECT_THAT(refusal({.curl = -1}), HasSubstr("curl"));
  EXPECT_THAT(refusal({.stretch = 0}), HasSubstr("stretch"));
  EXPECT_THROW(hypertexture_named("smoke"), InputError);
}

TEST(PlacedDensity, IsTheFunctionAtVoxelsOnAnyNumberOfThreads) {
  const auto density = [](Vec3 p) { return p.x < 2 ? -1 : (p.x + 10 * p.y + 100 * p.z) / 2000; };
  const Dims dims{9, 10, 11};
  for (const int threads : {1, 2}) {
    const PlacedScan placed = place_density(dims, density, threads);
    EXPECT_EQ(placed.high, (Vec3{8, 9, 10}));
    for (int i = 0; i < 9 * 10 * 11; ++i) {
      const Vec3 p{double(i % 9), double(i / 9 % 10), double(i / 90)};
      ASSERT_EQ(placed.density(p), static_cast<float>(density(p)));
    }
  }
}

}  // namespace
}  // namespace gicube::scene
