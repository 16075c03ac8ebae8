// Opacity, depth, compositing and energy, on both datapaths, against tests/support/reference/words.h, over their whole
// range or a million random words.
#include "datapath/composite.h"
#include "datapath/opacity_correction.h"
#include "datapath/ray_step.h"
#include "datapath/wide.h"
#include "random_words.h"
#include "reference/words.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(PipelineWords, CompositingAddsTheWeightOfWhatIsLeftAndTheColoursPartOfIt) {
  Words words(5);
  for (int i = 0; i < kMany; ++i) {
    RayState ray;
    ray.opacity = words.u32(0, wire::kOpacityOne);
    for (std::uint16_t& c : ray.colour) c = words.u16(0, 4095);
    const RayState before = ray;
    const Colour12 colour{static_cast<int>(words(0, 4095)), static_cast<int>(words(0, 4095)),
                          static_cast<int>(words(0, 4095))};
    const std::uint32_t alpha = words.u32(0, wire::kOpacityOne);
    over(ray, colour, alpha);
    const std::int64_t added = reference::product24(wire::kOpacityOne - before.opacity, alpha);
    ASSERT_EQ(ray.opacity, before.opacity + added);
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(ray.colour[c], std::min<std::int64_t>(before.colour[c] + reference::product24(colour[c], added), 4095));
    }
    ASSERT_EQ(contribution(ray.opacity), (wire::kOpacityOne - ray.opacity) / 4096);
  }
}

TEST(PipelineWords, OpacityCorrectionIsNearlyWithoutBiasAndExactAtItsEnds) {
  const OpacityCorrection correct;
  // Golden words, within the bound of the tables.
  for (const auto& [alpha, exponent] :
       {std::pair(0.5, 1.0), std::pair(0.25, 0.5), std::pair(0.01, 2.0), std::pair(0.9, 0.125)}) {
    const auto word = static_cast<std::uint16_t>(std::lround(alpha * 65535));
    const double exact = reference::corrected(word / 65535.0, exponent) * wire::kOpacityOne;
    EXPECT_NEAR(correct(word, static_cast<std::uint32_t>(exponent * 65536)), exact, 2) << alpha;
  }
  EXPECT_EQ(correct(65534, 65536), wire::kOpacityOne - 256);
  EXPECT_EQ(correct(65534, 8 << 16), wire::kOpacityOne) << "2^-128 is nothing";
  EXPECT_EQ(correct(65535 - 32768, 0), 0u);
  Words words(6);
  double worst = 0, sum = 0;
  for (int i = 0; i < kMany; ++i) {
    const std::uint16_t alpha = words.u16(0, 65535);
    const std::uint32_t exponent = words.u32(1, 4 << 16);
    const double error =
        correct(alpha, exponent) - reference::corrected(alpha / 65535.0, exponent / 65536.0) * wire::kOpacityOne;
    worst = std::max(worst, std::abs(error));
    sum += error;
  }
  EXPECT_LT(worst, 8);  // units of 2^-24 up to e = 4; 20 up to 16
  EXPECT_LT(std::abs(sum / kMany), 0.5) << "rounded to nearest, so nearly without bias";
}

TEST(PipelineWords, DepthIsTheLogarithmOfTheTransparencyAndItsTableHasExactKnots) {
  const OpacityCorrection correct;
  for (std::uint32_t alpha = 0; alpha < 65535; ++alpha) {
    const double exact = (std::log2(65535.0) - std::log2(65535.0 - alpha)) * 0x1p24;
    ASSERT_NEAR(correct.depth(static_cast<std::uint16_t>(alpha)), exact, 4) << alpha;
  }
  for (std::size_t i = 0; i <= OpacityCorrection::kSegments; ++i) {
    ASSERT_EQ(correct.exp2_at(i), std::lround(std::exp2(-static_cast<double>(i) / 1024) * wire::kOpacityOne));
  }
}

TEST(PipelineWords, WideOpacityIsExactToTwoUnitsOfAFloatsLastBit) {
  Words words(17);
  double worst = 0;
  for (int i = 0; i < kMany; ++i) {
    const auto depth = static_cast<float>(std::exp2(static_cast<double>(words(-24'000, 4'500)) / 1000));
    const std::uint32_t exponent = words.u32(1, 4 << 16);
    const double x = static_cast<double>(static_cast<float>(depth * (static_cast<float>(exponent) / 65536.0f)));
    const double exact = -std::expm1(-x * std::log(2.0));
    const double got = wide_alpha(depth, exponent);
    if (x < 31) worst = std::max(worst, std::abs(got - exact) / exact);
  }
  EXPECT_LT(worst, 2.1 / (1 << 24));
  EXPECT_EQ(wide_alpha(kOpaqueDepth, 1), 1);
  EXPECT_EQ(wide_alpha(1, 65536), 0.5f);
  EXPECT_EQ(wide_alpha(3, 65536), 0.875f);
  EXPECT_EQ(wide_alpha(63, 16 << 16), 1);
  EXPECT_EQ(wide_alpha(0, 65536), 0);
}

TEST(PipelineWords, WideCompositingSumsInFloatsAndThePacketFollowsRounded) {
  Words words(18);
  for (int i = 0; i < kMany; ++i) {
    RayState ray;
    WideWords wide;
    wide.opacity = static_cast<float>(words(0, 1 << 20)) / (1 << 20);
    for (float& c : wide.colour) c = static_cast<float>(words(0, 4095 << 4)) / 16;
    const WideWords before = wide;
    const Colour12 colour{static_cast<int>(words(0, 4095)), static_cast<int>(words(0, 4095)),
                          static_cast<int>(words(0, 4095))};
    const float alpha = static_cast<float>(words(0, 1 << 20)) / (1 << 20);
    over(ray, wide, colour, alpha);
    const double weight = (1 - double{before.opacity}) * alpha;
    ASSERT_NEAR(wide.opacity, alpha == 1 ? 1 : before.opacity + weight, 2e-7);
    const double units = double{wide.opacity} * wire::kOpacityOne;
    ASSERT_NEAR(ray.opacity, units, 0.5 + units * 0x1p-24);  // and the product's last bit
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_NEAR(wide.colour[c], before.colour[c] + weight * colour[c], 2e-3);
      ASSERT_EQ(ray.colour[c], std::min(std::lrint(wide.colour[c]), 4095L));
    }
  }
  const RayState half{.opacity = 1u << 23, .colour = {1, 2, 4095}};
  EXPECT_FLOAT_EQ(wide_words(half).opacity, 0.5f + 0.5f / wire::kOpacityOne);
  EXPECT_EQ(wide_words(half).colour, (std::array<float, 3>{1, 2, 4095}));
}

TEST(PipelineWords, WideDepthsAreHalvingsOfTheFineOpacity) {
  std::vector<wire::SegmentationEntry> entries(65536);
  Words words(19);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    entries[i].opacity = static_cast<std::uint16_t>(i);
    entries[i].opacity_fine = words.i16(-2048, 2047);
  }
  const std::vector<float> depths = wide_depths(entries);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const double units = static_cast<double>(i) + entries[i].opacity_fine / 4096.0;
    if (units >= 65535) {
      ASSERT_EQ(depths[i], kOpaqueDepth);
    } else {
      const double exact = units <= 0 ? 0 : -std::log2(1 - units / 65535);
      ASSERT_NEAR(depths[i], exact, 1e-6 * exact + 1e-12) << i;
    }
  }
}

TEST(PipelineWords, ALightingRaysContributionIsItsEnergyInSixteenthsUpToFull) {
  RayState ray;
  ray.flags = wire::kLightingRay;
  for (const auto& [energy, expected] : {std::pair(0.0, 0), std::pair(1.0, 16), std::pair(3.97, 63),
                                         std::pair(255.9375, 4095), std::pair(256.0, 4095), std::pair(1e6, 4095)}) {
    ray.set_energy(static_cast<std::uint64_t>(energy * 4096));
    EXPECT_EQ(contribution(ray), expected) << energy;
  }
  ray.flags = 0;
  ray.opacity = wire::kOpacityOne - 4095;
  EXPECT_EQ(contribution(ray), 0);
  ray.opacity = wire::kOpacityOne - 4096;
  EXPECT_EQ(contribution(ray), 1);
}

TEST(PipelineWords, EnergyAndAmountsFillTheColoursThirtySixBits) {
  RayState ray;
  ray.set_energy(0x9'8765'4321);
  EXPECT_EQ(ray.colour, (std::array<std::uint16_t, 3>{0x321, 0x654, 0x987}));
  EXPECT_EQ(ray.energy(), 0x9'8765'4321u);
  ray.set_amount(0xFF'FFFE);
  EXPECT_EQ(ray.amount(), -2);
  ray.set_amount(0x7F'FFFF);
  EXPECT_EQ(ray.amount(), 0x7F'FFFF);
}

}  // namespace
}  // namespace gicube::emu
