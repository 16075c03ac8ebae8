// The pipeline's stages against plain double-precision arithmetic and hand-worked words.
#include "datapath/composite.h"
#include "datapath/opacity_correction.h"
#include "datapath/ray_step.h"
#include "datapath/resample.h"
#include "datapath/shade.h"
#include "gicube/wire/registers.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(Fixed, DividesByFullScaleWithRoundingForEveryProductOfEightBits) {
  for (std::uint64_t a = 0; a < 256; ++a) {
    for (std::uint64_t b = 0; b < 256; ++b) {
      EXPECT_EQ(divide_by_full_scale<8>(a * b),
                static_cast<std::uint64_t>(std::lround(static_cast<double>(a * b) / 255)));
    }
  }
}

TEST(Fixed, KeepsAWordUnderFullScale) {
  for (const std::uint64_t x : {0u, 1u, 4095u, 0x7FFFFFu, 0xFFFFFFu})
    EXPECT_EQ(divide_by_full_scale<24>(x * wire::kOpacityOne), x);
}

TEST(Resample, GivesTheVoxelItselfAtAVoxel) {
  std::vector<ChannelWords> cell(8);
  for (std::size_t i = 0; i < 8; ++i) cell[i].channel = {static_cast<std::int16_t>(1000 * i), 16352, -16352, 7};
  const Neighbourhood at{0, 2, 4, {0, 0, 0}};
  EXPECT_EQ(resample_all(at, [&](std::size_t i) -> const ChannelWords& { return cell[i]; }),
            (Channels{0, 16352, -16352, 7}));
}

TEST(Resample, GivesTheSameBitsInLanesAsChannelByChannel) {
  std::mt19937 random(2);
  std::uniform_int_distribution<int> density(0, 4095 << kDensityFractionBits), gradient(-16352, 16352),
      fraction(0, wire::kVoxel - 1);
  for (int trial = 0; trial < 100'000; ++trial) {
    std::vector<ChannelWords> cell(8);
    for (auto& voxel : cell) {
      const bool extreme = trial % 3 == 0;
      const auto component = [&] {
        const int g = gradient(random);
        return static_cast<std::int16_t>(extreme ? (g < 0 ? -16352 : 16352) : g);
      };
      voxel.channel = {static_cast<std::int16_t>(density(random)), component(), component(), component()};
    }
    const auto weights = [&] { return weight(static_cast<std::uint32_t>(trial % 5 == 0 ? 0 : fraction(random))); };
    const Neighbourhood at{0, 2, 4, {weights(), weights(), weights()}};
    const auto words = [&](std::size_t i) -> const ChannelWords& { return cell[i]; };
    ASSERT_EQ(resample_all(at, words), resample_each(at, words)) << trial;
  }
}

TEST(Resample, StaysWithinOneAndAHalfUnitsOfTheExactTrilinearValue) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> density(0, 4095 << kDensityFractionBits), fraction(0, wire::kVoxel - 1);
  for (int trial = 0; trial < 20'000; ++trial) {
    std::vector<std::int16_t> cell(8);
    for (auto& voxel : cell) voxel = static_cast<std::int16_t>(density(random));
    const std::array<int, 3> f{fraction(random), fraction(random), fraction(random)};
    double exact = 0;
    for (int i = 0; i < 8; ++i) {
      double w = 1;
      for (int axis = 0; axis < 3; ++axis) {
        const double t = f[static_cast<std::size_t>(axis)] / double{wire::kVoxel};
        w *= (i >> axis & 1) != 0 ? t : 1 - t;
      }
      exact += w * cell[static_cast<std::size_t>(i)];
    }
    const Neighbourhood at{0,
                           2,
                           4,
                           {weight(static_cast<std::uint32_t>(f[0])), weight(static_cast<std::uint32_t>(f[1])),
                            weight(static_cast<std::uint32_t>(f[2]))}};
    EXPECT_NEAR(resample_density(cell.data(), at), exact, 1.5);  // three roundings in a row
  }
}

TEST(Resample, LerpsOppositeUnitGradientsWithoutOverflow) {
  const auto one = static_cast<std::int16_t>(kGradientUnit);
  EXPECT_EQ(lerp(static_cast<std::int16_t>(-one), one, 1 << 14), 0);
  EXPECT_EQ(lerp(one, static_cast<std::int16_t>(-one), (1 << 15) - 1), -one + 1);
}

TEST(Classify, RoundsToTheNearestDensityAndKeepsTheGreatestInRange) {
  EXPECT_EQ(segmentation_index(8 * 100 + 3, 0), 100u);
  EXPECT_EQ(segmentation_index(8 * 100 + 4, 0), 101u);
  EXPECT_EQ(segmentation_index(4095 << 3, 3), wire::kSegmentationEntries - 1);
}

TEST(OpacityCorrection, IsWithinTwentyUnitsOf24BitsForEveryOpacityAndManyExponents) {
  const OpacityCorrection correct;
  double worst = 0;
  for (const double e : {1.0 / 64, 0.25, 0.5, 0.75, 1.0, 1.7320508, 4.0, 16.0}) {
    const auto exponent = static_cast<std::uint32_t>(std::lround(e * 65536));
    for (std::uint32_t alpha = 0; alpha <= 65535; ++alpha) {
      const double exact = (1 - std::pow(1 - alpha / 65535.0, exponent / 65536.0)) * wire::kOpacityOne;
      worst = std::max(worst, std::abs(exact - correct(static_cast<std::uint16_t>(alpha), exponent)));
    }
  }
  EXPECT_LT(worst, 20);  // 1.2e-6: the tables' linear segments, times the largest exponent
}

TEST(OpacityCorrection, KeepsFullOpacityAndNoneForEveryExponent) {
  const OpacityCorrection correct;
  for (std::uint32_t exponent = 1; exponent < (1u << 26); exponent = exponent * 3 + 1) {
    EXPECT_EQ(correct(65535, exponent), wire::kOpacityOne);
    EXPECT_EQ(correct(0, exponent), 0u);
  }
}

TEST(OpacityCorrection, GrowsWithOpacityAndWithTheExponent) {
  const OpacityCorrection correct;
  for (std::uint32_t exponent : {1024u, 32768u, 65536u, 200'000u}) {
    std::uint32_t before = 0;
    for (std::uint32_t alpha = 0; alpha <= 65535; ++alpha) {
      const std::uint32_t now = correct(static_cast<std::uint16_t>(alpha), exponent);
      ASSERT_GE(now, before) << alpha;
      before = now;
    }
  }
  for (const std::uint16_t alpha : {std::uint16_t{1}, std::uint16_t{100}, std::uint16_t{30000}, std::uint16_t{65534}}) {
    std::uint32_t before = 0;
    for (std::uint32_t exponent = 1024; exponent < (1u << 24); exponent += exponent / 7) {
      const std::uint32_t now = correct(alpha, exponent);
      ASSERT_GE(now, before);
      before = now;
    }
  }
}

TEST(OpacityCorrection, KeepsTheTransmittanceOfThinFogOver512Steps) {
  // 8-bit opacity would lose this fog; 24 bits must keep it.
  const OpacityCorrection correct;
  for (const double alpha : {0.0004, 0.002, 0.01}) {
    const auto word = static_cast<std::uint16_t>(std::lround(alpha * 65535));
    RayState ray;
    for (int step = 0; step < 512; ++step) over(ray, {0, 0, 0}, correct(word, 32768));
    EXPECT_NEAR(1 - ray.opacity / double{wire::kOpacityOne}, std::pow(1 - word / 65535.0, 256), 3e-5);
  }
}

TEST(Composite, MakesAFullSampleFullAndLeavesNothingForTheNext) {
  RayState ray;
  over(ray, {4095, 2000, 0}, wire::kOpacityOne);
  EXPECT_EQ(ray.opacity, wire::kOpacityOne);
  EXPECT_EQ(ray.colour, (std::array<std::uint16_t, 3>{4095, 2000, 0}));
  over(ray, {4095, 4095, 4095}, wire::kOpacityOne);
  EXPECT_EQ(ray.colour, (std::array<std::uint16_t, 3>{4095, 2000, 0}));
  EXPECT_EQ(contribution(ray.opacity), 0);
}

TEST(Composite, FollowsPorterAndDuffWithinTheRoundingOfItsWords) {
  RayState ray;
  double colour = 0, opacity = 0;
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t alpha = 300'000 + 1000u * static_cast<unsigned>(i);
    over(ray, {3000, 0, 0}, alpha);
    const double a = alpha / double{wire::kOpacityOne};
    colour += (1 - opacity) * a * 3000 / 4095;
    opacity += (1 - opacity) * a;
  }
  EXPECT_NEAR(ray.opacity / double{wire::kOpacityOne}, opacity, 100 * 3e-8);
  EXPECT_NEAR(ray.colour[0] / 4095.0, colour, 100 * 0.5 / 4095);
}

TEST(Resample, OfABlockOfDensitiesTakesItsRowsAndSlices) {
  std::array<std::int16_t, 27> densities{};
  densities[13] = 800;  // in the middle of 3^3
  const BlockView view{densities.data(), nullptr, nullptr, nullptr};
  const auto at = [&view](std::size_t x, std::size_t y, std::size_t z, const std::array<std::uint32_t, 3>& fraction) {
    const Cell cell{{static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), static_cast<std::uint32_t>(z)},
                    fraction};
    return resample_density(view.densities, around({cell, view, 0, 3}));
  };
  constexpr std::uint32_t kQuarter = wire::kVoxel / 4;
  EXPECT_EQ(at(0, 1, 1, {kQuarter, 0, 0}), 200);
  EXPECT_EQ(at(1, 0, 1, {0, kQuarter, 0}), 200);
  EXPECT_EQ(at(1, 1, 0, {0, 0, kQuarter}), 200);
  EXPECT_EQ(at(1, 1, 1, {0, kQuarter, 0}), 600);
  EXPECT_EQ(at(1, 1, 1, {0, 0, kQuarter}), 600);
}

// A map whose texels are a linear function of the direction on each face.
std::vector<std::uint8_t> column_map() {
  std::vector<std::uint8_t> map(wire::kReflectanceBytes);
  for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<std::uint8_t>(i % 128);
  return map;
}

TEST(Shade, LooksTheOppositeOfTheGradientUpWithCornerAlignedTexels) {
  const auto map = column_map();
  const auto at = [&map](double b) {
    return reflectance(map.data(), {static_cast<int>(-b * 16352), 0, -16352}) / 256.0;
  };  // normal (b, 0, 1): face +z, column from x
  EXPECT_NEAR(at(-0.9999), 0, 0.02);
  EXPECT_NEAR(at(0), 63.5, 0.01);
  EXPECT_NEAR(at(0.9999), 127, 0.02);
  EXPECT_NEAR(at(0.25), 63.5 * 1.25, 0.05);
}

TEST(Shade, SplitsAShadeAtTheKneeIntoColourAndHighlight) {
  std::vector<std::uint8_t> map(wire::kReflectanceBytes, 192);  // 1.5 everywhere
  wire::SegmentationEntry entry;
  entry.colour = {2000, 1000, 0};
  entry.ambient = 0;
  entry.knee = 128;
  const Colour12 lit = shade(entry, {0, 0, 16000}, map.data());
  EXPECT_EQ(lit, (Colour12{4048, 3048, 2048}));  // colour * 1 + white * 0.5
}

TEST(Shade, LeavesASampleWithoutAGradientAsItIs) {
  std::vector<std::uint8_t> map(wire::kReflectanceBytes, 0);
  wire::SegmentationEntry entry;
  entry.colour = {2000, 1000, 10};
  EXPECT_EQ(shade(entry, {kShortestGradient - 1, 0, 0}, map.data()), (Colour12{2000, 1000, 10}));
  EXPECT_EQ(shade(entry, {kShortestGradient, 0, 0}, map.data()), (Colour12{0, 0, 0}));
}

}  // namespace
}  // namespace gicube::emu
