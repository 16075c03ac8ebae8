// Products, interpolators and their reverse, splats, against tests/support/reference/words.h, over their whole range or
// a million random words.
#include "datapath/fixed.h"
#include "datapath/resample.h"
#include "datapath/trilinear_splat.h"
#include "random_words.h"
#include "reference/words.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(PipelineWords, ProductsWithFullScaleOneAreTheNearestWords) {
  Words words(1);
  for (int i = 0; i < kMany; ++i) {
    const std::int64_t a = words(0, wire::kOpacityOne), b = words(0, wire::kOpacityOne);
    ASSERT_EQ(divide_by_full_scale<24>(static_cast<std::uint64_t>(a * b)),
              static_cast<std::uint64_t>(reference::product24(a, b)));
    const std::int64_t c = a & 0xFFF, d = b & 0xFFF;
    ASSERT_EQ(divide_by_full_scale<12>(static_cast<std::uint64_t>(c * d)),
              static_cast<std::uint64_t>(reference::nearest(c * d, 4095)));
  }
}

TEST(PipelineWords, SignedProductsAreRoundedHalfUp) {
  EXPECT_EQ(round_shift<16>(0x8000), 1);
  EXPECT_EQ(round_shift<16>(0x7FFF), 0);
  EXPECT_EQ(round_shift<16>(-0x8000), 0);
  EXPECT_EQ(round_shift<16>(-0x8001), -1);
  Words words(2);
  for (int i = 0; i < kMany; ++i) {
    const std::int64_t value = words(-(std::int64_t{1} << 40), std::int64_t{1} << 40);
    ASSERT_EQ(round_shift<16>(value), reference::nearest(value, 1 << 16));
  }
}

TEST(PipelineWords, SevenInterpolatorsAChannelAreRoundedOneByOne) {
  Words words(3);
  for (int i = 0; i < kMany / 4; ++i) {
    std::array<ChannelWords, 8> voxels{};
    std::array<std::int16_t, 8> densities{};
    std::array<std::array<std::int64_t, 8>, 4> cell{};
    for (std::size_t v = 0; v < 8; ++v) {
      voxels[v].channel = {words.i16(0, 4095 << 3), words.i16(-16352, 16352), words.i16(-16352, 16352),
                           words.i16(-16352, 16352)};
      densities[v] = voxels[v].channel[0];
      for (std::size_t c = 0; c < 4; ++c) cell[c][v] = voxels[v].channel[c];
    }
    const std::array<std::int64_t, 3> fraction{words(0, 16383), words(0, 16383), words(0, 16383)};
    std::array<int, 3> weights{};
    for (std::size_t axis = 0; axis < 3; ++axis) weights[axis] = weight(static_cast<std::uint32_t>(fraction[axis]));
    const Neighbourhood at{0, 2, 4, weights};
    const auto words_of = [&](std::size_t v) -> const ChannelWords& { return voxels[v]; };
    const Channels sample = resample_all(at, words_of);
    for (std::size_t c = 0; c < 4; ++c) ASSERT_EQ(sample[c], reference::trilinear(cell[c], fraction));
    ASSERT_EQ(resample_each(at, words_of), sample);
    ASSERT_EQ(resample_density(densities.data(), at), sample[0]);
  }
}

TEST(PipelineWords, TheLeastAndTheGreatestDensityAreThoseOfTheEightVoxels) {
  Words words(4);
  for (int i = 0; i < 100'000; ++i) {
    std::array<std::int16_t, 27> voxels{};
    for (std::int16_t& voxel : voxels) voxel = words.i16(0, 4095 << 3);
    std::int16_t least = 32767, greatest = 0;
    for (const std::size_t v : {0, 1, 3, 4, 9, 10, 12, 13}) {
      least = std::min(least, voxels[v]);
      greatest = std::max(greatest, voxels[v]);
    }
    const Neighbourhood at{0, 3, 9, {}};
    for (const DensityRange range : {density_range(voxels.data(), at), density_range_each(voxels.data(), at)}) {
      ASSERT_EQ(range.least, least);
      ASSERT_EQ(range.greatest, greatest);
    }
  }
}

TEST(PipelineWords, ADensityIsRoundedToTheLutsIndexHalvesUp) {
  for (unsigned tag = 0; tag < 4; ++tag) {
    for (int density = 0; density <= 4095 << 3; ++density) {
      ASSERT_EQ(segmentation_index(density, tag),
                tag * 4096 + static_cast<std::size_t>(reference::nearest(density, 8)));
    }
  }
}

// Systematic rounding: the sum of the shares up to voxel i is the whole part of units times the weights up to it, plus
// one fraction for all. The weights' product has 42 bits, of which 28 count.
TEST(PipelineWords, ASplatsSharesAreTheStepsOfOneRoundedRunningSum) {
  Words words(20);
  std::mt19937_64 random(20);
  for (int i = 0; i < kMany / 4; ++i) {
    const std::uint32_t units = words.u32(0, i % 2 == 0 ? 300 : 0xFFFF'FFFF);
    const std::array<std::uint32_t, 3> fraction{words.u32(0, 16383), words.u32(0, 16383), words.u32(0, 16383)};
    const std::uint64_t chance = random();
    const Shares shares = split(units, fraction, chance);
    long double sum = 0;
    std::uint64_t given = 0;
    for (std::size_t v = 0; v < 8; ++v) {
      long double share = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const long double f = fraction[axis] / 16384.0L;
        share *= (v >> axis) % 2 == 1 ? f : 1 - f;
      }
      sum += share;
      given += shares[v];
      const long double exact =
          units * (std::floor(sum * 0x1p28L) * 0x1p-28L) + static_cast<long double>(chance >> 36) * 0x1p-28L;
      ASSERT_EQ(given, static_cast<std::uint64_t>(std::floor(exact)));
    }
    ASSERT_EQ(given, units);
  }
}

TEST(PipelineWords, ASignedAmountIsSpreadByTheInterpolatorsTreeRunBackwards) {
  Words words(21);
  for (int i = 0; i < kMany / 4; ++i) {
    const auto amount = static_cast<std::int32_t>(words(-(1 << 23), (1 << 23) - 1));
    const std::array<std::uint32_t, 3> fraction{words.u32(0, 16383), words.u32(0, 16383), words.u32(0, 16383)};
    const SignedShares shares = spread(amount, fraction);
    // Along z, then y, then x; the upper half is rounded, halves up, and the lower half has the rest.
    for (std::size_t v = 0; v < 8; ++v) {
      std::int64_t part = amount;
      for (std::size_t axis = 3; axis-- > 0;) {
        const std::int64_t upper = reference::nearest(part * fraction[axis], 16384);
        part = (v >> axis) % 2 == 1 ? upper : part - upper;
      }
      ASSERT_EQ(shares[v], part);
    }
  }
}

}  // namespace
}  // namespace gicube::emu
