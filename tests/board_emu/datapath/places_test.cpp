// Where within its step a ray is absorbed or scattered, and which random numbers decide that.
#include "datapath/random_stream.h"
#include "datapath/scatter.h"
#include "fog.h"
#include "test.h"

namespace gicube::emu {
namespace {

// The depth at which photons are absorbed is exponential: a quarter of those of a part lie before where a quarter of
// its absorption is passed.
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

// A quarter of a step of 8191 units is 2047.75 of them.
TEST(Shares, APlaceIsRoundedToTheNearestUnit) {
  Fog fog;
  Frame& frame = fog.lit.scene.frame;
  frame.rules = wire::EnergyRules::kConserving;
  frame.step = wire::kStepOne / 2;
  fog.set(30'000, 0, wire::Bsdf::kNone);
  fog.lit.scene.set_depths();
  wire::Ray packet;
  packet.position = {9u << 12, 2u << 14, 2u << 14};  // its cell has the next sample too
  packet.direction = {16382, 0, 0};
  packet.flags = wire::kLightingRay;
  RayState ray = unpack(packet, frame);
  ray.set_energy(std::uint64_t{200} << kEnergyFractionBits);
  ASSERT_EQ(ray.slope(0), 8191);
  EXPECT_EQ(fog.take(ray).place[0], (9 << 12) + 2048);
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

}  // namespace
}  // namespace gicube::emu
