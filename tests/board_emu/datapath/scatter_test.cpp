#include "datapath/scatter.h"

#include "datapath/jitter.h"
#include "datapath/trilinear_splat.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr std::array<std::uint32_t, 3> kCubes{65536, 65536, 65536};
constexpr double kOne = 1 << wire::kDirectionFractionBits;

wire::Material material(wire::Bsdf bsdf, double gloss = 0) {
  wire::Material out;
  out.bsdf = bsdf;
  out.gloss = static_cast<std::uint16_t>(gloss * (1 << wire::kGlossFractionBits));
  return out;
}

Direction direction(double x, double y, double z) { return wire::direction_words({x, y, z}, kCubes); }

double along(const Direction& a, double x, double y, double z) { return (a[0] * x + a[1] * y + a[2] * z) / kOne; }

struct Mean {
  double z = 0, z_squared = 0, min_z = 1;
};

Mean mean_of(const wire::Material& of, const Direction& in, const Point& gradient) {
  Mean mean;
  constexpr int kDraws = 40'000;
  for (int i = 0; i < kDraws; ++i) {
    const double z = along(scattered(of, in, gradient, kCubes, wire::mix64(static_cast<std::uint64_t>(i))), 0, 0, 1);
    mean.z += z / kDraws;
    mean.z_squared += z * z / kDraws;
    mean.min_z = std::min(mean.min_z, z);
  }
  return mean;
}

TEST(Scattering, AMirrorTurnsTheComponentAlongTheNormalRound) {
  const Direction out = scattered(material(wire::Bsdf::kSpecular), direction(0.6, 0, -0.8), {0, 0, -500}, kCubes, 1);
  EXPECT_NEAR(along(out, 1, 0, 0), 0.6, 1e-4);
  EXPECT_NEAR(along(out, 0, 0, 1), 0.8, 1e-4);
  EXPECT_EQ(out, scattered(material(wire::Bsdf::kDullReflection), direction(0.6, 0, -0.8), {0, 0, -500}, kCubes, 99));
}

TEST(Scattering, AMirrorReflectsInPhysicalSpaceWhereVoxelsAreLong) {
  const std::array<std::uint32_t, 3> spacing{65536, 65536, 2 * 65536};
  const std::array<double, 3> in{0.6, 0, -0.8};  // physical
  // A plane that is tilted by 45 degrees in physical space turns x into z.
  const Direction out =
      scattered(material(wire::Bsdf::kSpecular), wire::direction_words(in, spacing), {-500, 0, -500}, spacing, 1);
  const std::array<double, 3> physical = wire::physical_direction(out, spacing);
  EXPECT_NEAR(physical[0], 0.8, 2e-4);
  EXPECT_NEAR(physical[2], -0.6, 2e-4);
}

TEST(Scattering, ASurfaceWithoutANormalSendsTheRayBack) {
  const Direction in = direction(0.6, 0, -0.8);
  EXPECT_EQ(scattered(material(wire::Bsdf::kSpecular), in, {0, 0, 0}, kCubes, 1), direction(-0.6, 0, 0.8));
}

TEST(Scattering, IsotropicDirectionsAreEvenOverTheSphere) {
  const Mean mean = mean_of(material(wire::Bsdf::kIsotropic), direction(1, 0, 0), {0, 0, -500});
  EXPECT_NEAR(mean.z, 0, 0.01);
  EXPECT_NEAR(mean.z_squared, 1.0 / 3, 0.005);
}

TEST(Scattering, ADiffuseSurfaceSendsRaysByTheCosineOfTheirAngleToTheNormal) {
  const Mean mean = mean_of(material(wire::Bsdf::kDiffuse), direction(0.6, 0, -0.8), {0, 0, -500});
  EXPECT_NEAR(mean.z, 2.0 / 3, 0.005);
  EXPECT_NEAR(mean.z_squared, 1.0 / 2, 0.005);
  EXPECT_GE(mean.min_z, 0);
}

TEST(Scattering, GlossSpreadsAReflectionAndNoneGoesIntoTheSurface) {
  const Direction in = direction(0.98, 0, -0.2);
  const Mean little = mean_of(material(wire::Bsdf::kDullReflection, 0.05), in, {0, 0, -500});
  const Mean much = mean_of(material(wire::Bsdf::kDullReflection, 1), in, {0, 0, -500});
  EXPECT_NEAR(little.z, 0.2, 0.01);
  EXPECT_GT(much.z_squared - much.z * much.z, 20 * (little.z_squared - little.z * little.z));
  EXPECT_GE(much.min_z, 0);
}

TEST(Scattering, DullScatteringKeepsItsDirectionAsFarAsItsGlossIsSmall) {
  const Mean mean = mean_of(material(wire::Bsdf::kDullScattering, 0.1), direction(0, 0, 1), {500, 0, 0});
  EXPECT_GT(mean.z, 0.99);
  EXPECT_GT(mean.min_z, 0.99);
}

TEST(Scattering, DirectionsStayUnitVectors) {
  std::mt19937 dice(3);
  for (int i = 0; i < 2000; ++i) {
    const auto number = [&dice] { return static_cast<int>(dice() % 1001) - 500; };
    const Direction in = direction(number() + 0.5, number() + 0.5, number() + 0.5);
    const auto bsdf = static_cast<wire::Bsdf>(dice() % 6);
    const Direction out = scattered(material(bsdf, static_cast<double>(dice() % 160) / 10), in,
                                    {number(), number(), number()}, kCubes, wire::mix64(dice()));
    EXPECT_NEAR(std::hypot(out[0], out[1], out[2]) / kOne, 1, 1e-4);
  }
}

TEST(Splat, SharesSumToTheDeposit) {
  std::mt19937 engine(5);
  const auto dice = [&engine] { return static_cast<std::uint32_t>(engine()); };
  for (int i = 0; i < 5000; ++i) {
    const std::uint32_t units = i % 2 == 0 ? dice() % 256 : dice() % (1u << 24);
    const std::array<std::uint32_t, 3> fraction{dice() % 16384, dice() % 16384, dice() % 16384};
    std::uint64_t sum = 0;
    for (const std::uint32_t share : split(units, fraction, wire::mix64(dice()))) sum += share;
    EXPECT_EQ(sum, units);
  }
}

TEST(Splat, OneUnitGoesToAVoxelAsOftenAsItsWeightSays) {
  const std::array<std::uint32_t, 3> fraction{4096, 8192, 12288};  // 1/4, 1/2, 3/4
  std::array<double, 8> got{};
  constexpr int kDraws = 40'000;
  for (int i = 0; i < kDraws; ++i) {
    const Shares shares = split(1, fraction, wire::mix64(static_cast<std::uint64_t>(i)));
    for (std::size_t v = 0; v < 8; ++v) got[v] += shares[v] / double{kDraws};
  }
  for (std::size_t v = 0; v < 8; ++v) {
    const double weight = ((v & 1) != 0 ? 0.25 : 0.75) * 0.5 * ((v >> 2) != 0 ? 0.75 : 0.25);
    EXPECT_NEAR(got[v], weight, 0.01) << v;
  }
}

TEST(Splat, APlaceOnAVoxelGivesItAll) {
  EXPECT_EQ(split(200, {0, 0, 0}, ~std::uint64_t{0}), (Shares{200, 0, 0, 0, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace gicube::emu
