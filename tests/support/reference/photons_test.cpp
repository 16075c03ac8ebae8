// The Monte Carlo against closed forms and converged numbers.
#include "photons.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "slab_table.h"

namespace gicube::reference {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Within four standard errors, and the error small enough to mean something.
void expect_near(const Estimate& estimate, double expected, double last_digit, const char* what) {
  EXPECT_LT(std::abs(estimate.mean - expected), 4 * estimate.error + last_digit) << what;
  EXPECT_LT(estimate.error, 2e-3) << what;
}

TEST(Photons, PassAndReturnFromSlabsAsTheTableSays) {
  for (const SlabRow& row : kSlabTable) {
    SCOPED_TRACE(testing::Message() << "tau " << row.optical_thickness << " albedo " << row.albedo);
    const Fates fates = slab(row.optical_thickness, row.albedo, 200'000, 11);
    expect_near(fates.back, row.reflected, 1e-4, "R");
    expect_near(fates.through, row.transmitted, 1e-4, "T");
    EXPECT_NEAR(fates.back.mean + fates.through.mean + fates.absorbed.mean, 1, 1e-9);
    EXPECT_EQ(fates.sideways.mean, 0);
  }
}

TEST(Photons, ReturnFromHalfSpacesAsTheTableSays) {
  for (const HalfSpaceRow& row : kHalfSpaceTable)
    expect_near(slab(kInfinity, row.albedo, 200'000, 5).back, row.reflected, 1e-5, "R");
}

TEST(Photons, FallOffExponentiallyWithoutScattering) {
  expect_near(slab(1.5, 0, 100'000, 3).through, std::exp(-1.5), 0, "T");
}

TEST(Photons, CollideOneOverOneMinusAlbedoTimesInAnInfiniteMedium) {
  const Vec3 infinity{kInfinity, kInfinity, kInfinity};
  for (const double albedo : {0.0, 0.5, 0.9}) {
    const Fates fates = follow({-1.0 * infinity, infinity, 1, albedo}, 50'000, 7, [](Random& random) {
      return Photon{{}, random.direction()};
    });
    EXPECT_NEAR(fates.collisions * (1 - albedo), 1, 0.01) << albedo;
    EXPECT_NEAR(fates.absorbed.mean, 1, 1e-12);
  }
}

TEST(Photons, OfAPointSourceAreAbsorbedExponentiallyWithDistance) {
  const Vec3 infinity{kInfinity, kInfinity, kInfinity};
  std::array<double, 4> shells{};
  constexpr int kPhotons = 100'000;
  follow(
      {-1.0 * infinity, infinity, 0.5, 0}, kPhotons, 9,
      [](Random& random) {
        return Photon{{}, random.direction()};
      },
      [&](Vec3 position, double weight) {
        const double r = length(position);
        if (r < 4) shells[static_cast<std::size_t>(r)] += weight;
      });
  for (int r = 0; r < 4; ++r) {
    const double expected = std::exp(-0.5 * r) - std::exp(-0.5 * (r + 1));
    EXPECT_NEAR(shells[static_cast<std::size_t>(r)] / kPhotons, expected, 4 * std::sqrt(expected / kPhotons)) << r;
  }
}

// A photon from the faces of the 2 x 3 x 4 box, as uniform radiance outside would send it in.
Photon from_outside(Random& random) {
  const double pick = random.uniform() * 26, s = random.uniform(), t = random.uniform();  // half the surface
  const bool far = random.uniform() < 0.5;
  const double side = far ? -1 : 1;
  if (pick < 6) return {{2 * s, 3 * t, far ? 4.0 : 0.0}, random.diffuse({0, 0, side})};
  if (pick < 14) return {{2 * s, far ? 3.0 : 0.0, 4 * t}, random.diffuse({0, side, 0})};
  return {{far ? 2.0 : 0.0, 3 * s, 4 * t}, random.diffuse({side, 0, 0})};
}

TEST(Photons, MakeAFurnaceOfConstantRadiance) {
  std::array<double, 8> parts{};  // the box cut in eight
  constexpr int kPhotons = 100'000;
  const Fates fates = follow({{0, 0, 0}, {2, 3, 4}, 1.5, 1}, kPhotons, 13, from_outside, [&](Vec3 p, double weight) {
    parts[(p.x > 0.5 ? 1u : 0u) + (p.y > 1 ? 2u : 0u) + (p.z > 1 ? 4u : 0u)] += weight;
  });
  // The mean path through a body is 4 volume / surface, whatever it scatters; collisions are extinction times that.
  const double expected = 1.5 * 4 * 24 / 52;
  EXPECT_NEAR(fates.collisions, expected, 0.01 * expected);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const double share =
        ((i & 1) != 0 ? 0.75 : 0.25) * ((i & 2) != 0 ? 2.0 / 3 : 1.0 / 3) * ((i & 4) != 0 ? 0.75 : 0.25);
    const double mean = share * expected * kPhotons;
    EXPECT_NEAR(parts[i] / mean, 1, 8 / std::sqrt(mean)) << i;  // collisions of a photon come in clusters
  }
  EXPECT_EQ(fates.absorbed.mean, 0);
}

}  // namespace
}  // namespace gicube::reference
