// Each value function of the pipeline against tests/support/reference/words.h, over its whole range or a million random words.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <random>
#include <vector>

#include "datapath/advance.h"
#include "datapath/classify.h"
#include "datapath/composite.h"
#include "datapath/illuminate.h"
#include "datapath/jitter.h"
#include "datapath/opacity_correction.h"
#include "datapath/random_stream.h"
#include "datapath/ray_step.h"
#include "datapath/resample.h"
#include "datapath/shade.h"
#include "datapath/splat.h"
#include "datapath/trilinear_splat.h"
#include "datapath/wide.h"
#include "reference/words.h"

namespace gicube::emu {
namespace {

constexpr int kMany = 1'000'000;

// Whole numbers from `low` to `high`, its ends often.
class Words {
 public:
  explicit Words(unsigned seed) : random_(seed) {}
  std::int64_t operator()(std::int64_t low, std::int64_t high) {
    const std::uint64_t kind = random_() % 16;
    if (kind == 0) return low;
    if (kind == 1) return high;
    return low + static_cast<std::int64_t>(random_() % static_cast<std::uint64_t>(high - low + 1));
  }
  std::uint32_t u32(std::int64_t low, std::int64_t high) { return static_cast<std::uint32_t>((*this)(low, high)); }
  std::uint16_t u16(std::int64_t low, std::int64_t high) { return static_cast<std::uint16_t>((*this)(low, high)); }
  std::int16_t i16(std::int64_t low, std::int64_t high) { return static_cast<std::int16_t>((*this)(low, high)); }

 private:
  std::mt19937_64 random_;
};

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
    std::array<DecodedVoxel, 8> voxels{};
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
    const Channels sample = resample_all({voxels.data(), 2, 4, weights});
    for (std::size_t c = 0; c < 4; ++c) {
      ASSERT_EQ(sample[c], reference::trilinear(cell[c], fraction));
      ASSERT_EQ(resample({voxels.data(), 2, 4, weights}, c), sample[c]);
    }
    ASSERT_EQ(resample_density(densities.data(), 2, 4, weights), sample[0]);
  }
}

TEST(PipelineWords, TheLeastAndTheGreatestDensityAreThoseOfTheEightVoxels) {
  Words words(4);
  for (int i = 0; i < 100'000; ++i) {
    std::array<DecodedVoxel, 27> voxels{};
    for (DecodedVoxel& voxel : voxels) voxel.channel = {words.i16(0, 4095 << 3), -1, 0, 1};
    std::int16_t least = 32767, greatest = 0;
    for (const std::size_t v : {0, 1, 3, 4, 9, 10, 12, 13}) {
      least = std::min(least, voxels[v].channel[0]);
      greatest = std::max(greatest, voxels[v].channel[0]);
    }
    const DensityRange range = density_range({voxels.data(), 3, 9, {}});
    ASSERT_EQ(range.least, least);
    ASSERT_EQ(range.greatest, greatest);
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

TEST(PipelineWords, AStepIsTheDirectionTimesItsLengthRoundedHalfUp) {
  Words words(7);
  for (int i = 0; i < kMany; ++i) {
    const std::array<std::int16_t, 3> direction{words.i16(-16384, 16384), words.i16(-16384, 16384),
                                                words.i16(-16384, 16384)};
    const std::uint32_t length = words.u32(0, 16 << 16);
    const Point step = step_vector(direction, length);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(step[axis], reference::nearest(std::int64_t{direction[axis]} * length, 65536));
    }
  }
}

TEST(PipelineWords, AVoxelLengthAlongTheRayIsItsPhysicalLength) {
  Words words(8);
  for (int i = 0; i < 100'000; ++i) {
    const std::array<std::int16_t, 3> direction{words.i16(-9000, 9000), words.i16(-9000, 9000), words.i16(1, 9000)};
    const std::array<std::uint32_t, 3> spacing{words.u32(4096, 1 << 20), words.u32(4096, 1 << 20),
                                               words.u32(4096, 1 << 20)};
    double physical = 0, voxels = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      physical = std::hypot(physical, double(direction[axis]) * spacing[axis]);
      voxels = std::hypot(voxels, double(direction[axis]));
    }
    ASSERT_NEAR(physical_length(direction, spacing), physical / voxels, 0.5 + 1e-6);
  }
  EXPECT_EQ(physical_length({1, 2, 3}, {70'000, 70'000, 70'000}), 70'000u);
  EXPECT_EQ(physical_length({3, 4, 0}, {5 * 65536, 0, 7}), 3u * 65536);
  EXPECT_EQ(physical_length({0, 4, 3}, {7, 0, 5 * 65536}), 3u * 65536);
}

TEST(PipelineWords, ASampleStandsForItsStepTimesThePhysicalLength) {
  Words words(9);
  for (int i = 0; i < kMany; ++i) {
    RayState ray;
    ray.length = words.u32(1, 16 << 16);
    const std::uint32_t distance = words.u32(1, 16 << 16);
    space(ray, distance, {});
    ASSERT_EQ(ray.exponent, reference::nearest(std::int64_t{distance} * ray.length, 65536));
  }
}

TEST(PipelineWords, APositionIsInsideUpToBothFacesOfEachAxis) {
  const Point extent{100, 200, 300};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Point at{50, 60, 70};
    for (const auto& [value, expected] : {std::pair(-1, false), std::pair(0, true), std::pair(extent[axis], true),
                                          std::pair(extent[axis] + 1, false)}) {
      at[axis] = value;
      EXPECT_EQ(inside(at, extent), expected) << axis << ' ' << value;
    }
  }
}

TEST(PipelineWords, ARayOnACutPlaneIsNotBeyondIt) {
  const Plane plane{{0, 16384, 0}, std::int64_t{10} << kPlaneFractionBits};
  const int on = 10 * wire::kVoxel;
  EXPECT_FALSE(beyond(plane, {0, on, 0}, {0, -1, 0}));
  EXPECT_TRUE(beyond(plane, {0, on - 1, 0}, {0, -1, 0}));
  EXPECT_FALSE(beyond(plane, {0, on - 1, 0}, {1, 0, 0})) << "it runs along the plane";
}

// SplitMix64 seeded with 0, 1 and 2: its first numbers (from the generator's own C source).
TEST(PipelineWords, TheHashIsThatOfSplitMix64) {
  constexpr std::uint64_t kGamma = 0x9E3779B97F4A7C15;
  EXPECT_EQ(mix64(kGamma), 0xE220A8397B1DCDAFu);
  EXPECT_EQ(mix64(2 * kGamma), 0x6E789E6AA1B965F4u);
  EXPECT_EQ(mix64(3 * kGamma), 0x06C45D188009454Fu);
}

TEST(PipelineWords, JitterHasEachStratumOnceAndItsPlaceComesFromPositionAndDestination) {
  std::array<std::uint32_t, 256> sorted = kJitterLut;
  std::sort(sorted.begin(), sorted.end());
  for (std::uint32_t i = 0; i < 256; ++i) ASSERT_EQ(sorted[i], 32768 + i * 128 + 64);  // 1/2 + (i + 1/2) / 512
  // Golden entries, shuffled apart from this tree.
  EXPECT_EQ(kJitterLut[0], 47552u);
  EXPECT_EQ(kJitterLut[1], 50880u);
  EXPECT_EQ(kJitterLut[127], 37568u);
  EXPECT_EQ(kJitterLut[255], 39744u);
  int moved = 0;
  for (std::size_t i = 0; i < 256; ++i) moved += kJitterLut[i] != sorted[i];
  EXPECT_GT(moved, 240);
  Words words(10);
  for (int i = 0; i < 100'000; ++i) {
    const Point at{static_cast<int>(words(0, (1 << 24) - 1)), static_cast<int>(words(0, (1 << 24) - 1)),
                   static_cast<int>(words(0, (1 << 24) - 1))};
    const std::uint16_t u = words.u16(0, 65535), v = words.u16(0, 65535);
    // The packet's bits in their order: 24 each of x and y; 24 of z, 16 each of u and v.
    const std::uint64_t low = static_cast<std::uint64_t>(at[0]) + (static_cast<std::uint64_t>(at[1]) << 24);
    const std::uint64_t high = static_cast<std::uint64_t>(at[2]) + (std::uint64_t{u} << 24) + (std::uint64_t{v} << 40);
    ASSERT_EQ(jitter(at, u, v), kJitterLut[reference::mixed(reference::mixed(low) ^ high) & 255]);
  }
}

TEST(PipelineWords, AJitteredStepIsTheStepTimesTheFactor) {
  Frame frame;
  Words words(11);
  for (int i = 0; i < 100'000; ++i) {
    frame.step = words.u32(1, 16 << 16);
    const std::uint32_t factor = words.u32(kJitterOne / 2, kJitterOne);
    ASSERT_EQ(jittered(frame, factor), reference::nearest(std::int64_t{frame.step} * factor, 65536));
  }
}

TEST(PipelineWords, DrawsHashRayFlightPlaceSeedAndPurpose) {
  Words words(12);
  for (int i = 0; i < 100'000; ++i) {
    const std::uint16_t u = words.u16(0, 65535), v = words.u16(0, 65535), lifetime = words.u16(0, 1023);
    const std::uint32_t seed = words.u32(0, 0xFFFF'FFFF);
    const auto what = static_cast<RandomStream>(words(1, 8));
    const std::uint64_t ray = u + (std::uint64_t{v} << 16) + (std::uint64_t{lifetime} << 32);
    const std::uint64_t drawn =
        reference::mixed(reference::mixed(ray) ^ ((std::uint64_t{seed} << 8) + static_cast<std::uint64_t>(what)));
    ASSERT_EQ(draw(what, u, v, lifetime, seed), drawn);
    const Point at{static_cast<int>(words(0, (1 << 24) - 1)), static_cast<int>(words(0, (1 << 24) - 1)),
                   static_cast<int>(words(0, (1 << 24) - 1))};
    const std::uint64_t place = static_cast<std::uint64_t>(at[0]) + (static_cast<std::uint64_t>(at[1]) << 32);
    ASSERT_EQ(draw_at(what, at, u, v, lifetime, seed),
              reference::mixed(reference::mixed(reference::mixed(place) ^ static_cast<std::uint64_t>(at[2])) ^ drawn));
  }
}

std::vector<std::uint8_t> random_map(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> map(wire::kReflectanceBytes);
  for (std::uint8_t& texel : map) texel = static_cast<std::uint8_t>(random());
  return map;
}

// Whether a float quotient decides the texel's last bit otherwise than a double one may.
bool near_a_tie(const Point& gradient) {
  const int largest = std::max({std::abs(gradient[0]), std::abs(gradient[1]), std::abs(gradient[2])});
  for (const int g : gradient) {
    const double place = std::abs(g) / double(largest) * 63.5 * 256, rest = place - std::floor(place);
    if (std::abs(rest - 0.5) < 0.01) return true;
  }
  return false;
}

TEST(PipelineWords, TheReflectanceMapIsCornerAlignedAndBilinearOnAllSixFaces) {
  const std::vector<std::uint8_t> map = random_map(1);
  Words words(13);
  for (int i = 0; i < kMany; ++i) {
    const Point gradient{static_cast<int>(words(-16352, 16352)), static_cast<int>(words(-16352, 16352)),
                         static_cast<int>(words(-16352, 16352))};
    const int largest = std::max({std::abs(gradient[0]), std::abs(gradient[1]), std::abs(gradient[2])});
    const bool two_are_largest =
        (std::abs(gradient[0]) == largest) + (std::abs(gradient[1]) == largest) + (std::abs(gradient[2]) == largest) >
        1;
    if (largest == 0 || two_are_largest || near_a_tie(gradient)) continue;
    const double exact = reference::reflected(map, {-double(gradient[0]), -double(gradient[1]), -double(gradient[2])});
    ASSERT_NEAR(reflectance(map.data(), gradient), exact * 32768, 0.5 + 1e-6)
        << gradient[0] << ' ' << gradient[1] << ' ' << gradient[2];
  }
}

// Of two axes that are as long the lower one's face is taken.
TEST(PipelineWords, AnEdgeOfTheReflectanceMapBelongsToTheLowerAxis) {
  std::vector<std::uint8_t> map(wire::kReflectanceBytes);
  for (std::size_t i = 0; i < map.size(); ++i) map[i] = static_cast<std::uint8_t>(i / (128 * 128) * 10);
  const auto face = [&map](const Point& gradient) { return reflectance(map.data(), gradient) / 2560; };
  EXPECT_EQ(face({-500, -500, 0}), 0);
  EXPECT_EQ(face({500, -500, 500}), 1);
  EXPECT_EQ(face({0, -500, -500}), 2);
  EXPECT_EQ(face({0, 500, -500}), 3);
  EXPECT_EQ(face({499, 0, -500}), 4);
  EXPECT_EQ(face({0, 499, 500}), 5);
}

TEST(PipelineWords, AShadeScalesTheColourUpToTheKneeAndAddsWhiteAbove) {
  const std::vector<std::uint8_t> map = random_map(2);
  Words words(14);
  for (int i = 0; i < kMany; ++i) {
    wire::SegmentationEntry entry;
    for (std::uint16_t& c : entry.colour) c = words.u16(0, 4095);
    entry.ambient = static_cast<std::uint8_t>(words(0, 255));
    entry.reflect = static_cast<std::uint8_t>(words(0, 255));
    entry.knee = static_cast<std::uint8_t>(words(0, 255));
    const Point gradient{static_cast<int>(words(-16352, 16352)), static_cast<int>(words(-16352, 16352)),
                         static_cast<int>(words(1022, 16352))};
    const std::int64_t total =
        entry.ambient * 256 + reference::nearest(std::int64_t{entry.reflect} * reflectance(map.data(), gradient), 128);
    const std::int64_t base = std::min<std::int64_t>(total, entry.knee * 256);
    const Colour12 lit = shade(entry, gradient, map.data());
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int64_t sum = entry.colour[c] * base + 4095 * (total - base);
      ASSERT_EQ(lit[c], std::min<std::int64_t>(reference::nearest(sum, 1 << 15), 4095));
    }
  }
}

TEST(PipelineWords, ASampleIsShadedFromASixteenthOfAUnitGradientOn) {
  EXPECT_EQ(kShortestGradient, 511 * 32 / 16);
  const std::vector<std::uint8_t> black(wire::kReflectanceBytes, 0);
  wire::SegmentationEntry entry;
  entry.colour = {4095, 5, 6};
  // 613 and 818 with the hypotenuse 1022.2; 612 and 818 with 1021.6.
  EXPECT_EQ(shade(entry, {613, -818, 0}, black.data()), (Colour12{0, 0, 0}));
  EXPECT_EQ(shade(entry, {0, 612, -818}, black.data()), (Colour12{4095, 5, 6}));
}

TEST(PipelineWords, IrradianceIsInterpolatedWithFourFractionBitsAndSaturates) {
  Words words(15);
  for (int i = 0; i < kMany / 4; ++i) {
    const bool wide = i % 2 == 1;
    std::array<std::uint32_t, 8> cell{};
    std::array<std::int64_t, 8> exact{};
    for (std::size_t v = 0; v < 8; ++v) {
      cell[v] = words.u32(0, wide ? 0xFFFF'FFFF : 2047);
      exact[v] = std::min<std::int64_t>(wide ? cell[v] / 4096 : std::int64_t{cell[v]} * 16, 32767);
    }
    const std::array<std::int64_t, 3> fraction{words(0, 16383), words(0, 16383), words(0, 16383)};
    std::array<int, 3> weights{};
    for (std::size_t axis = 0; axis < 3; ++axis) weights[axis] = weight(static_cast<std::uint32_t>(fraction[axis]));
    // Differences of words up to 32767 fit the interpolator.
    ASSERT_EQ(irradiance(cell.data(), 2, 4, weights, wide),
              static_cast<std::uint32_t>(std::max<std::int64_t>(reference::trilinear(exact, fraction), 0)));
  }
}

// Irradiance 11.4, gain 8.8 and exposure 16.16 make a shade of 15 fraction bits, rounded; so does the highlight, in 1/128.
TEST(PipelineWords, ALitSampleHasItsColourTimesIrradianceGainAndExposure) {
  const std::vector<std::uint8_t> map = random_map(3);
  Words words(16);
  for (int i = 0; i < kMany; ++i) {
    wire::SegmentationEntry entry;
    for (std::uint16_t& c : entry.colour) c = words.u16(0, 4095);
    entry.ambient = static_cast<std::uint8_t>(words(0, 255));
    entry.specular = static_cast<std::uint8_t>(words(0, 255));
    entry.set_gain(words.u32(0, i % 2 == 0 ? 65535 : 300));
    const std::uint32_t light = words.u32(0, i % 3 == 0 ? 32767 : 100), exposure = words.u32(0, 1 << 17);
    const Point gradient{static_cast<int>(words(-16352, 16352)), static_cast<int>(words(-16352, 16352)),
                         static_cast<int>(words(0, 16352))};
    const double length = std::hypot(gradient[0], gradient[1], gradient[2]);
    const std::int64_t product = std::int64_t{light} * entry.gain() * exposure;
    const std::int64_t lit = std::min<std::int64_t>(reference::nearest(product, 1 << 13), 8 << 15);
    const std::int64_t highlight =
        length < 1022 ? 0 : reference::nearest(std::int64_t{entry.specular} * reflectance(map.data(), gradient), 128);
    const Colour12 got = illuminated(entry, light, exposure, gradient, map.data());
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int64_t sum = entry.colour[c] * (lit + entry.ambient * 256) + 4095 * highlight;
      ASSERT_EQ(got[c], std::min<std::int64_t>(reference::nearest(sum, 1 << 15), 4095));
    }
  }
  wire::SegmentationEntry white;
  white.colour = {4095, 4095, 4095};
  white.set_gain(256);
  EXPECT_EQ(illuminated(white, 8, 65536, {}, map.data()), (Colour12{2048, 2048, 2048})) << "2047.5 rounded up";
  white.set_gain(1);
  EXPECT_EQ(illuminated(white, 9, 4096, {}, map.data()), (Colour12{1, 1, 1})) << "a shade of 4.5 is 5: 0.62 units";
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

// Systematic rounding: the sum of the shares up to voxel i is the whole part of units times the weights up to it, plus one
// fraction for all. The weights' product has 42 bits, of which 28 count.
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
