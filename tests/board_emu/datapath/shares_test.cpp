// How a sample's opacity is shared between absorption and scattering, word by word: what a ray holds after one sample
// of a uniform volume against tests/support/reference/words.h.
#include "datapath/random_stream.h"
#include "fog.h"
#include "reference/words.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(Shares, ARenderingRayTakesTheAbsorbedPartRoundedToTheNearestWord) {
  Fog fog;
  fog.lit.scene.frame.type = wire::RayType::kIntegrate;
  fog.lit.scene.frame.scatter = true;
  std::mt19937 random(1);
  for (int i = 0; i < 200'000; ++i) {
    const auto opacity = static_cast<std::uint16_t>(1 + random() % 65535),
               ks = static_cast<std::uint16_t>(random() % 65536);
    fog.set(opacity, ks, wire::Bsdf::kIsotropic);
    RayState ray = fog.ray(0, static_cast<std::uint16_t>(i));
    fog.take(ray);
    ASSERT_EQ(ray.opacity, reference::absorbed(alpha_of(fog), ks)) << opacity << ' ' << ks;
  }
}

TEST(Shares, OfWhatIsNotAbsorbedALightingRayAccumulatesTheScatteredShare) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  std::mt19937 random(2);
  int kept = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto opacity = static_cast<std::uint16_t>(1 + random() % 40'000),
               ks = static_cast<std::uint16_t>(random() % 65536);
    fog.set(opacity, ks, wire::Bsdf::kIsotropic);
    fog.lit.scene.set_depths();
    RayState ray = fog.ray(wire::kLightingRay, static_cast<std::uint16_t>(i));
    ray.under_way = true;  // else the part begins at the sample
    ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
    const Interaction out = fog.take(ray);
    if (out.outcome != Outcome::kGoesOn || ray.generation != 0) continue;
    ++kept;
    const double a = alpha_of(fog) / double{wire::kOpacityOne};
    ASSERT_NEAR(ray.interacted, reference::scattered_share(a, ks / 65535.0) * wire::kOpacityOne, 0.5 + 1e-6)
        << opacity << ' ' << ks;
  }
  EXPECT_GT(kept, 500);
}

// 36 bits of energy show each unit of the 24 of the absorbed share.
TEST(Shares, ALightingRayLosesTheAbsorbedShareOfItsEnergy) {
  Fog fog;
  fog.lit.scene.frame.wide = true;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  std::mt19937 random(3);
  constexpr std::uint64_t kEnergy = (std::uint64_t{1} << 36) - (1 << 13);
  for (int i = 0; i < 3000; ++i) {
    const auto opacity = static_cast<std::uint16_t>(1 + random() % 65534),
               ks = static_cast<std::uint16_t>(random() % 65536);
    fog.set(opacity, ks, wire::Bsdf::kIsotropic);
    fog.lit.scene.set_depths();
    RayState ray = fog.ray(wire::kLightingRay, static_cast<std::uint16_t>(i));
    ray.under_way = true;
    ray.set_energy(kEnergy);
    fog.take(ray);
    const auto lost = static_cast<double>(kEnergy - ray.energy()) / static_cast<double>(kEnergy) * wire::kOpacityOne;
    ASSERT_NEAR(lost, static_cast<double>(reference::absorbed(alpha_of(fog), ks)), 1e-3) << opacity << ' ' << ks;
  }
}

TEST(Shares, ThePrintedRulesTakeAllOfTheOpacityAndDepositTheAbsorbedPart) {
  Fog fog;
  fog.set(20'000, 49'151, wire::Bsdf::kIsotropic);  // Ks = 3/4
  double deposited = 0, lost = 0;
  for (std::uint16_t i = 0; i < 20'000; ++i) {
    RayState ray = fog.ray(wire::kLightingRay, i);
    ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
    const Interaction out = fog.take(ray);
    if (out.deposits) deposited += out.units[0];
    lost += 200 - static_cast<double>(ray.energy()) / 4096;
  }
  const double a = alpha_of(fog) / double{wire::kOpacityOne};
  EXPECT_NEAR(lost / 20'000, 200 * a, 0.01);
  EXPECT_NEAR(deposited / 20'000, 200 * a / 4, 0.05);
  EXPECT_NEAR(static_cast<double>(fog.counters.energy.scattered_away) / 20'000, 200 * a * 3 / 4, 0.05);
  EXPECT_EQ(fog.counters.deposits, 20'000u);
}

TEST(Shares, OfOneSampleAPhotonIsAbsorbedScatteredOrPassesByItsOpacity) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(30'000, 45'875, wire::Bsdf::kIsotropic);  // Ks = 0.7
  fog.lit.scene.set_depths();
  constexpr int kRays = 60'000;
  int absorbed = 0, scattered = 0;
  for (int i = 0; i < kRays; ++i) {
    RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo, static_cast<std::uint16_t>(i));
    ray.under_way = true;
    ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
    const Interaction out = fog.take(ray);
    absorbed += out.outcome == Outcome::kEnded;
    scattered += ray.generation == 1;
    if (out.outcome == Outcome::kEnded) {
      ASSERT_EQ(out.units[0], 15u);
    }
    ASSERT_EQ(ray.energy(), std::uint64_t{15} << kEnergyFractionBits);
  }
  const double a = alpha_of(fog) / double{wire::kOpacityOne}, sigma = 0.5 / std::sqrt(kRays);
  EXPECT_NEAR(absorbed / double{kRays}, a * 0.3, 4 * sigma);
  EXPECT_NEAR(scattered / double{kRays}, a * 0.7, 4 * sigma);
  EXPECT_EQ(fog.counters.scatterings, static_cast<std::uint64_t>(scattered));
}

TEST(Shares, OfOneSampleARenderingRayIsScatteredByItsPartOfWhatIsNotAbsorbed) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kIntegrate;
  frame.rules = wire::EnergyRules::kConserving;
  frame.scatter = true;
  fog.set(20'000, 19'661, wire::Bsdf::kIsotropic);  // Ks = 0.3
  constexpr int kRays = 60'000;
  int scattered = 0;
  for (int i = 0; i < kRays; ++i) {
    RayState ray = fog.ray(0, static_cast<std::uint16_t>(i));
    ASSERT_EQ(fog.take(ray).outcome, Outcome::kGoesOn);
    scattered += ray.generation == 1;
  }
  const double share = reference::scattered_share(alpha_of(fog) / double{wire::kOpacityOne}, 0.3);
  EXPECT_NEAR(scattered / double{kRays}, share, 4 * std::sqrt(share * (1 - share) / kRays));
}

TEST(Shares, OnTheWideDatapathARenderingRayTakesTheAbsorbedPartInFloats) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kIntegrate;
  frame.scatter = true;
  std::mt19937 random(9);
  for (int i = 0; i < 50; ++i) {
    const auto opacity = static_cast<std::uint16_t>(1 + random() % 65534),
               ks = static_cast<std::uint16_t>(random() % 65536);
    fog.set(opacity, ks, wire::Bsdf::kIsotropic);
    fog.lit.scene.widen();
    RayState ray = fog.ray(0, static_cast<std::uint16_t>(i));
    fog.take(ray);
    const double exact = opacity / 65535.0 * (1 - ks / 65535.0);
    ASSERT_NEAR(ray.wide.opacity, exact, 1e-6 * exact) << opacity << ' ' << ks;
  }
}

// The loss is rounded up if the draw's fraction is more than what is missing to a whole unit of the energy's word.
TEST(Shares, TheLossOfEnergyIsRoundedByADrawOfItsPlace) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.seed = 5;
  fog.set(1, 0, wire::Bsdf::kNone);
  const std::int64_t a = alpha_of(fog), one = wire::kOpacityOne;
  for (std::uint16_t i = 0; i < 2000; ++i) {
    RayState ray = fog.ray(wire::kLightingRay, i);
    ray.v = static_cast<std::uint16_t>(7 * i);
    const std::int64_t energy = 1000 + 13 * i;
    ray.set_energy(static_cast<std::uint64_t>(energy));
    fog.take(ray);
    const std::uint64_t drawn =
        draw_at(RandomStream::kLoss, {5 << 13, 2 << 14, 2 << 14}, i, ray.v, ray.lifetime, 5) >> 40;
    const auto chance = static_cast<std::int64_t>(drawn * static_cast<std::uint64_t>(one) >> 24);
    ASSERT_EQ(ray.energy(), static_cast<std::uint64_t>(energy - (energy * a + chance) / one));
  }
}

TEST(Shares, ALightingRaysEnergyIsRoundedByOneDrawForAllItsDeposits) {
  Fog fog;
  for (const double energy : {0.25, 0.5, 7.75}) {
    double sum = 0;
    for (std::uint16_t i = 0; i < 20'000; ++i) {
      RayState ray = fog.ray(wire::kLightingRay, i);
      ray.set_energy(static_cast<std::uint64_t>(energy * 4096));
      sum += energy_units(ray, fog.lit.scene.frame);
    }
    EXPECT_NEAR(sum / 20'000, energy, 0.015);
  }
}

}  // namespace
}  // namespace gicube::emu
