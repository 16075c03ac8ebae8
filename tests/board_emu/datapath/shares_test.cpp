// How a sample's opacity is shared between absorption and scattering, word by word: what a ray holds after one sample of a
// uniform volume against tests/support/reference/words.h.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "datapath/interaction.h"
#include "datapath/random_stream.h"
#include "datapath/scattering.h"
#include "lighting_rig.h"
#include "reference/words.h"

namespace gicube::emu {
namespace {

// A volume of one opacity; a step is a voxel long.
struct Fog {
  Fog() : lit({5, 5, 5}, 8, false) { lit.scene.frame.rules = wire::EnergyRules::kAsPrinted; }

  void set(std::uint16_t opacity, std::uint16_t scattering, wire::Bsdf bsdf) {
    lit.scene.segmentation[0].opacity = opacity;
    lit.scene.frame.materials[0].bsdf = bsdf;
    lit.scene.frame.materials[0].scattering = scattering;
    lit.scene.frame.materials[0].flags = wire::kScattersRenderingRays;
  }
  // A ray along x in the middle of a cell: its sample's part reaches from face to face.
  RayState ray(std::uint8_t flags, std::uint16_t number) const {
    wire::Ray packet;
    packet.u = number;
    packet.position = {5u << 13, 2u << 14, 2u << 14};
    packet.direction = {16384, 0, 0};
    packet.flags = flags;
    return unpack(packet, lit.scene.frame);
  }
  Interaction take(RayState& ray) {
    const Frame& frame = lit.scene.frame;
    const BlockGrid grid(*frame.volume);
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(grid.block(ray.position));
    return interact(ray, {at, view, grid.block(ray.position), 9}, frame, counters);
  }

  LitScene lit;
  RayCounters counters;
};

std::uint32_t alpha_of(const Fog& fog) {
  return (*fog.lit.scene.frame.opacity_correction)(fog.lit.scene.segmentation[0].opacity, 65536);
}

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
    ASSERT_NEAR(ray.interacted, reference::scattered_share(a, ks / 65535.0) * wire::kOpacityOne, 1.0)
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
    if (out.deposits) deposited += out.units;
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
      ASSERT_EQ(out.units, 15u);
    }
    ASSERT_EQ(ray.energy(), std::uint64_t{15} << kEnergyFractionBits);
  }
  const double a = alpha_of(fog) / double{wire::kOpacityOne}, sigma = 0.5 / std::sqrt(kRays);
  EXPECT_NEAR(absorbed / double{kRays}, a * 0.3, 4 * sigma);
  EXPECT_NEAR(scattered / double{kRays}, a * 0.7, 4 * sigma);
  EXPECT_EQ(fog.counters.scatterings, static_cast<std::uint64_t>(scattered));
}

// The depth at which photons are absorbed is exponential: a quarter of those of a part lie before where a quarter of its
// absorption is passed.
TEST(Shares, PlacesOfAbsorptionFollowTheExponentialWithinTheSample) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(50'000, 0, wire::Bsdf::kNone);
  fog.lit.scene.set_depths();
  const double depth = -std::log1p(-50'000 / 65535.0), all = -std::expm1(-depth);
  std::array<int, 8> seen{};
  int count = 0;
  for (int i = 0; i < 60'000; ++i) {
    RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo, static_cast<std::uint16_t>(i));
    ray.under_way = true;
    ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
    const Interaction out = fog.take(ray);
    if (!out.deposits) continue;
    const double way = out.place[0] / double{wire::kVoxel} - 2;
    ASSERT_GE(way, 0);
    ASSERT_LE(way, 1);
    ++seen[static_cast<std::size_t>(std::min(-std::expm1(-depth * way) / all * 8, 7.99))];
    ++count;
  }
  double chi = 0;
  for (const int n : seen) chi += std::pow(n - count / 8.0, 2) / (count / 8.0);
  EXPECT_LT(chi, 24.3);  // 7 degrees of freedom, one in a thousand
}

// The opacity's last half unit stands for what is opaque: log 2^25 = 17.3 depths, of which the mean photon passes one.
TEST(Shares, InAnOpaqueMediumPhotonsEndASeventeenthOfThePartBehindItsBegin) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(65535, 0, wire::Bsdf::kNone);
  fog.lit.scene.set_depths();
  double mean = 0;
  constexpr int kRays = 20'000;
  for (int i = 0; i < kRays; ++i) {
    RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo, static_cast<std::uint16_t>(i));
    ray.under_way = true;
    ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
    const Interaction out = fog.take(ray);
    ASSERT_TRUE(out.deposits);
    mean += (out.place[0] / double{wire::kVoxel} - 2) / kRays;
  }
  EXPECT_NEAR(mean, 1 / std::log(0x1p25), 0.002);
}

TEST(Shares, ABundleLeavesItsDepositWhereHalfOfTheDepthIsPassed) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(30'000, 0, wire::Bsdf::kNone);
  fog.lit.scene.set_depths();
  for (const bool first : {false, true}) {
    RayState ray = fog.ray(wire::kLightingRay, 3);
    ray.under_way = !first;
    ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
    const Interaction out = fog.take(ray);
    ASSERT_TRUE(out.deposits);
    EXPECT_EQ(out.place[0], (5 << 13) + (first ? 4096 : 0));  // a first part has only the half behind the sample
    EXPECT_EQ(out.place[1], 2 << 14);
    EXPECT_EQ(ray.position[0], 7 << 13);
  }
}

// Which numbers are drawn: those of the ray, its flight and the place where it is scattered.
TEST(Shares, AScatteredRaysDirectionIsDrawnByItsPlaceItsNumberItsFlightAndTheSeed) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.rules = wire::EnergyRules::kConserving;
  frame.seed = 99;
  fog.set(65535, 65535, wire::Bsdf::kIsotropic);
  fog.lit.scene.set_depths();
  for (std::uint16_t i = 1; i < 200; ++i) {
    RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo, i);
    ray.v = static_cast<std::uint16_t>(3 * i);
    ray.lifetime = 700;
    ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
    fog.take(ray);
    ASSERT_EQ(ray.generation, 1);
    const std::uint64_t drawn = draw_at(RandomStream::kDirection, ray.position, i, ray.v, 700, 99);
    EXPECT_EQ(ray.direction, scattered(frame.materials[0], {16384, 0, 0}, {}, frame.spacing, drawn));
  }
}

TEST(Shares, WhetherAPhotonIsScatteredIsDrawnByItsNumberItsFlightAndTheSeed) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.rules = wire::EnergyRules::kConserving;
  frame.seed = 7;
  fog.set(65535, 26'214, wire::Bsdf::kIsotropic);  // Ks = 0.4
  fog.lit.scene.set_depths();
  for (std::uint16_t i = 1; i < 500; ++i) {
    RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo, i);
    ray.v = static_cast<std::uint16_t>(3 * i);
    ray.lifetime = 700;
    ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
    fog.take(ray);
    const auto drawn = static_cast<double>(draw(RandomStream::kAbsorption, i, ray.v, 700, 7) >> 48) / 65536;
    ASSERT_EQ(ray.generation == 1, drawn < 26'214 / 65535.0);
  }
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

// A ray that was scattered at a surface passes it, until it has been outside.
TEST(Shares, ATrappedRayPassesItsMaterialUntilItHasLeftIt) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  const auto taken = [&fog](std::uint16_t opacity, wire::Bsdf bsdf) {
    fog.set(opacity, 65535, bsdf);
    fog.lit.scene.set_depths();
    RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo | wire::kTrapped, 4);
    ray.under_way = true;
    ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
    fog.take(ray);
    return ray;
  };
  const RayState inside = taken(65535, wire::Bsdf::kTrap);
  EXPECT_TRUE(inside.is(wire::kTrapped));
  EXPECT_EQ(inside.position[0], 7 << 13);
  EXPECT_EQ(inside.interacted, 0u);
  const RayState outside = taken(0, wire::Bsdf::kTrap);
  EXPECT_FALSE(outside.is(wire::kTrapped));
  EXPECT_EQ(outside.position[0], 7 << 13);
  const RayState elsewhere = taken(65535, wire::Bsdf::kIsotropic);
  EXPECT_FALSE(elsewhere.is(wire::kTrapped));
  EXPECT_EQ(elsewhere.generation, 1) << "another material scatters it";
}

// What the host's routine is told of a ray, and what it does to the ray by its answer.
struct Caught : HostTrapQueue {
  void add(const wire::TrappedRay& ray) override { rays.push_back(ray); }
  std::vector<wire::TrappedRay> rays;
};

TEST(Traps, TellTheHostTheRaySampleAndFourRandomNumbers) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  Caught caught;
  frame.host_traps = &caught;
  frame.seed = 11;
  frame.materials[0].routine = wire::kHostRoutine;
  fog.lit.scene.segmentation[1234].opacity = 4321;
  // Codes of the scene's codebook; all voxels have one.
  fog.lit.scene.fill([](int, int, int) { return wire::Voxel{1234, 700, 0, 0}; });
  RayState ray = fog.ray(wire::kLightingRay | wire::kTrapped, 21);
  ray.v = 22;
  ray.lifetime = 23;
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  RayCounters counters;
  std::uint32_t cycles = 7;
  EXPECT_EQ(resolve_trap(ray, frame, counters, cycles).outcome, Outcome::kTrapped);
  EXPECT_EQ(cycles, 0u);
  ASSERT_EQ(caught.rays.size(), 1u);
  const wire::TrappedRay& told = caught.rays[0];
  EXPECT_EQ(told.ray.u, 21);
  EXPECT_EQ(told.ray.v, 22);
  EXPECT_EQ(told.ray.position[0], 5u << 13);
  EXPECT_EQ(told.density, 1234 << 3);
  EXPECT_EQ(told.opacity, 4321);
  EXPECT_EQ(told.tag, 0);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_EQ(told.gradient[axis], fog.lit.scene.gradients[700][axis] * 32);
  std::uint64_t drawn = draw_at(RandomStream::kRoutine, ray.position, 21, 22, 23, 11);
  for (const std::uint32_t number : told.random) {
    EXPECT_EQ(number, drawn >> 32);
    drawn = reference::mixed(drawn + 1);
  }
}

TEST(Traps, AnAnswerDropsItsShareOfEnergyAndBeginsAFlight) {
  Fog fog;
  const Frame& frame = fog.lit.scene.frame;
  wire::Ray packet;
  packet.u = 3;
  packet.position = {5u << 13, 2u << 14, 2u << 14};
  packet.direction = {0, 0, -16384};
  packet.flags = wire::kLightingRay;
  packet.lifetime = 10;
  packet.set_colour_word(std::uint64_t{100} << kEnergyFractionBits);
  wire::set_dropped_share(packet, wire::dropped_share(0.75));
  RayCounters counters;
  wire::Ray on = packet;
  EXPECT_FALSE(take_answer(on, frame, counters));
  EXPECT_EQ(counters.energy.emitted, 100u);
  EXPECT_EQ(counters.energy.scattered_away, 25u);
  EXPECT_NEAR(static_cast<double>(on.colour_word()) / 4096, 75, 1e-3);
  EXPECT_EQ(on.lifetime, 9);
  EXPECT_EQ(on.generation, 1);
  EXPECT_EQ(on.direction, packet.direction);
  wire::Ray gone = packet;
  wire::set_dropped_share(gone, wire::kOpacityOne);
  EXPECT_TRUE(take_answer(gone, frame, counters));
  EXPECT_EQ(counters.energy.scattered_away, 125u);
  EXPECT_EQ(counters.rays, 1u) << "the first one goes on";
  wire::Ray seen = packet;
  seen.flags = 0;
  seen.opacity = 0;
  seen.set_colour_word(0);
  EXPECT_FALSE(take_answer(seen, frame, counters));
  EXPECT_NEAR(seen.opacity, 0.25 * wire::kOpacityOne, 1) << "a rendering ray gathers black";
}

TEST(Shares, ARayThatMeetsATrapWaitsThereWithItsMaterialsTag) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(65535, 65535, wire::Bsdf::kTrap);
  fog.lit.scene.set_depths();
  RayState ray = fog.ray(wire::kLightingRay | wire::kHighAlbedo, 4);
  ray.set_energy(std::uint64_t{15} << kEnergyFractionBits);
  EXPECT_EQ(fog.take(ray).outcome, Outcome::kTrapped);
  EXPECT_TRUE(ray.is(wire::kTrapped));
  EXPECT_EQ(ray.flags >> kTrapTagShift, 0);
  EXPECT_EQ(fog.counters.traps, 1u);
  EXPECT_EQ(fog.counters.scatterings, 1u);
  EXPECT_EQ(ray.lifetime, wire::kLifetimeMax) << "it is counted down when the routine has answered";
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

TEST(Shares, EndsAreCountedByTheirCauseAndTheEnergyThatLeaves) {
  Fog fog;
  RayState ray = fog.ray(wire::kLightingRay, 1);
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  RayCounters counters;
  count_end(ray, Termination::kLeft, fog.lit.scene.frame, counters);
  EXPECT_EQ(counters.rays, 1u);
  EXPECT_EQ(counters.lighting_rays, 1u);
  EXPECT_EQ(counters.energy.escaped, 100u);
  EXPECT_EQ(counters.terminated, 0u);
  count_end(ray, Termination::kAbsorbed, fog.lit.scene.frame, counters);
  EXPECT_EQ(counters.energy.escaped, 100u);
  ray.flags = 0;
  count_end(ray, Termination::kOpaque, fog.lit.scene.frame, counters);
  EXPECT_EQ(counters.rays, 3u);
  EXPECT_EQ(counters.lighting_rays, 2u);
  EXPECT_EQ(counters.terminated, 1u);
}

TEST(Shares, ARayAtTheEndOfItsLifetimeGivesItsEnergyUp) {
  Fog fog;
  fog.lit.scene.frame.rules = wire::EnergyRules::kConserving;
  fog.set(65535, 65535, wire::Bsdf::kIsotropic);
  fog.lit.scene.set_depths();
  RayState ray = fog.ray(wire::kLightingRay, 1);
  ray.lifetime = 0;
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  EXPECT_EQ(fog.take(ray).outcome, Outcome::kEnded);
  EXPECT_EQ(fog.counters.energy.scattered_away, 100u);
  EXPECT_EQ(fog.counters.energy.given_up, 100u);
  EXPECT_EQ(fog.counters.scatterings, 0u);
  ray = fog.ray(wire::kLightingRay, 1);
  ray.lifetime = 1;
  ray.set_energy(std::uint64_t{100} << kEnergyFractionBits);
  EXPECT_EQ(fog.take(ray).outcome, Outcome::kGoesOn);
  EXPECT_EQ(ray.lifetime, 0);
  EXPECT_EQ(ray.generation, 1);
  EXPECT_EQ(ray.energy(), std::uint64_t{100} << kEnergyFractionBits);
}

// One pass each: what it counts, and how far it goes.
TEST(Passes, OfASegmentEndWithItsStepsWhetherItGathersOrLeaps) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kOpacity;
  frame.step = wire::kStepOne / 8;
  fog.set(1000, 0, wire::Bsdf::kNone);
  wire::Ray packet;
  packet.position = {1u << 13, 2u << 14, 2u << 14};
  packet.direction = {16384, 0, 0};
  packet.set_colour_word(2u << 16);  // two voxels: 16 steps
  const BlockGrid grid(*frame.volume);
  RayState ray = unpack(packet, frame);
  RayCounters counters;
  for (int taken = 0; taken < 16; ++taken) {
    ASSERT_EQ(end(ray, frame), Termination::kNot);
    ASSERT_EQ(ray.steps_left(), 16 - taken);
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(0);
    gather(ray, {at, view, 0, 9}, frame, counters);
  }
  EXPECT_EQ(end(ray, frame), Termination::kLeft);
  EXPECT_EQ(counters.samples, 16u);
  EXPECT_EQ(counters.visible_samples, 16u);
  EXPECT_NEAR(ray.opacity / double{wire::kOpacityOne}, reference::corrected(1000 / 65535.0, 2), 1e-5);

  ray = unpack(packet, frame);
  EXPECT_EQ(leap(ray, {0, 0, 0}, 8 << 14, frame, counters), 16) << "the segment ends before its block";
  EXPECT_EQ(ray.steps_left(), 0);
  EXPECT_EQ(counters.leaps, 1u);
  EXPECT_EQ(counters.samples, 16u);
  EXPECT_TRUE(ray.under_way);
  packet.set_colour_word(30u << 16);
  ray = unpack(packet, frame);
  EXPECT_EQ(leap(ray, {0, 0, 0}, 2 << 14, frame, counters), 12) << "the first sample lies at 9/16";
  EXPECT_EQ(ray.steps_left(), 240 - 12);
}

TEST(Passes, OfABackprojectingRayLeaveItsAmountAtEachStepOfItsSegment) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kBackproject;
  frame.step = wire::kStepOne / 8;
  wire::Ray packet;
  packet.position = {1u << 13, 2u << 14, 2u << 14};
  packet.direction = {16384, 0, 0};
  packet.opacity = 5 << wire::kAmountFractionBits;
  packet.set_colour_word(2u << 16);
  RayState ray = unpack(packet, frame);
  const BlockGrid grid(*frame.volume);
  RayCounters counters;
  for (int taken = 0; taken < 16; ++taken) {
    ASSERT_EQ(end(ray, frame), Termination::kNot);
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(0);
    const Interaction left = sample(ray, {at, view, 0, 9}, frame, counters);
    EXPECT_TRUE(left.deposits);
    EXPECT_EQ(left.units, 5u);
  }
  EXPECT_EQ(end(ray, frame), Termination::kLeft);
  EXPECT_EQ(counters.samples, 16u);
  EXPECT_EQ(counters.visible_samples, 16u);
  EXPECT_EQ(counters.deposits, 16u);
  EXPECT_EQ(counters.energy.emitted, 80u);
}

TEST(Passes, OfARenderingRayGatherItsColourAndOpacity) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kIntegrate;
  fog.set(20'000, 0, wire::Bsdf::kNone);
  fog.lit.scene.segmentation[0].colour = {4000, 2000, 7};
  const BlockGrid grid(*frame.volume);
  for (const bool colourless : {false, true}) {
    frame.type = colourless ? wire::RayType::kFirstHit : wire::RayType::kIntegrate;
    RayState ray = fog.ray(0, 1), expected = ray;
    const Cell at = cell(ray.position, grid.low(ray.position));
    const BlockView view = frame.volume->view(0);
    RayCounters counters;
    gather(ray, {at, view, 0, 9}, frame, counters);
    over(expected, colourless ? Colour12{} : Colour12{4000, 2000, 7}, alpha_of(fog));
    EXPECT_EQ(ray.opacity, expected.opacity);
    EXPECT_EQ(ray.colour, expected.colour);
    EXPECT_EQ(ray.position[0], 7 << 13);
  }
}

// A hit is the sample before the ray's place; a segment's end half a step before it; what lies outside is put on the face.
TEST(Packets, HoldWhatARayGatheredAndWhereItEnded) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  RayState ray = fog.ray(0, 9);
  ray.v = 77;
  ray.opacity = 5'000'000;
  ray.colour = {1, 2, 3};
  ray.lifetime = 44;
  ray.generation = 5;
  const auto packed = [&](wire::RayType type, std::uint32_t threshold) {
    frame.type = type;
    frame.opacity_threshold = threshold;
    return pack(ray, frame);
  };
  const wire::Ray plain = packed(wire::RayType::kIntegrate, 5'000'000);
  EXPECT_EQ(plain.position, (std::array<std::uint32_t, 3>{5u << 13, 2u << 14, 2u << 14}));
  EXPECT_EQ(plain.u, 9);
  EXPECT_EQ(plain.v, 77);
  EXPECT_EQ(plain.opacity, 5'000'000u);
  EXPECT_EQ(plain.colour, ray.colour);
  EXPECT_EQ(plain.contribution, (wire::kOpacityOne - 5'000'000) >> 12);
  EXPECT_EQ(plain.lifetime, 44);
  EXPECT_EQ(plain.generation, 5);
  EXPECT_EQ(plain.direction, ray.direction);
  EXPECT_EQ(packed(wire::RayType::kFirstHit, 5'000'000).position[0], 3u << 13);
  EXPECT_EQ(packed(wire::RayType::kFirstHit, 5'000'001).position[0], 5u << 13);
  EXPECT_EQ(packed(wire::RayType::kSegment, 5'000'001).position[0], 2u << 14);
  ray.position[0] = 9 << 14;
  EXPECT_EQ(packed(wire::RayType::kIntegrate, 5'000'001).position[0], 4u << 14);
  ray.position[0] = -3;
  EXPECT_EQ(packed(wire::RayType::kIntegrate, 5'000'001).position[0], 0u);
}

// A rendering ray's sample stands for the step behind it: it is scattered there, exponentially.
TEST(Shares, ARenderingRayIsScatteredWithinTheStepBehindItsSample) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.type = wire::RayType::kIntegrate;
  frame.rules = wire::EnergyRules::kConserving;
  frame.scatter = frame.high_albedo = true;
  fog.set(50'000, 65535, wire::Bsdf::kIsotropic);
  const double depth = -std::log1p(-50'000 / 65535.0);
  double mean = 0;
  int count = 0;
  for (int i = 0; i < 40'000; ++i) {
    RayState ray = fog.ray(0, static_cast<std::uint16_t>(i));
    fog.take(ray);
    if (ray.generation == 0) continue;
    const double way = ray.position[0] / double{wire::kVoxel} - 2.5;
    ASSERT_GE(way, 0);
    ASSERT_LE(way, 1);
    mean += way;
    ++count;
  }
  EXPECT_NEAR(mean / count, 1 / depth - 1 / std::expm1(depth), 0.006);  // four standard errors
}

TEST(Passes, OfALightingRayCountItsSampleAndTakeItOffTheSurface) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  fog.set(1000, 0, wire::Bsdf::kNone);
  RayState ray = fog.ray(wire::kLightingRay | wire::kTrapped, 1);
  ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
  const BlockGrid grid(*frame.volume);
  const Cell at = cell(ray.position, grid.low(ray.position));
  const BlockView view = frame.volume->view(0);
  RayCounters counters;
  leap(ray, {0, 0, 0}, 8 << 14, frame, counters);
  EXPECT_FALSE(ray.is(wire::kTrapped));
  ray = fog.ray(wire::kLightingRay, 1);
  ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
  sample(ray, {at, view, 0, 9}, frame, counters);
  EXPECT_EQ(counters.samples, 1u);
  EXPECT_EQ(counters.visible_samples, 1u);
  fog.set(0, 0, wire::Bsdf::kNone);
  sample(ray, {at, view, 0, 9}, frame, counters);
  EXPECT_EQ(counters.samples, 2u);
  EXPECT_EQ(counters.visible_samples, 1u);
}

TEST(Shares, GenerationsSaturateAtFifteen) {
  Fog fog;
  RayState ray = fog.ray(wire::kLightingRay, 1);
  for (int i = 0; i < 20; ++i) {
    redirect(ray, {0, 16384, 0}, fog.lit.scene.frame);
    EXPECT_EQ(ray.generation, std::min(i + 1, 15));
  }
  EXPECT_EQ(ray.lifetime, wire::kLifetimeMax - 20);
  EXPECT_EQ(ray.step, (Point{0, 16384, 0}));
  EXPECT_EQ(ray.interacted, 0u);
}

}  // namespace
}  // namespace gicube::emu
