// Shades by the reflectance map and by irradiance against tests/support/reference/words.h, over their whole range or a
// million random words.
#include "datapath/illuminate.h"
#include "datapath/resample.h"
#include "datapath/shade.h"
#include "random_words.h"
#include "reference/words.h"
#include "test.h"

namespace gicube::emu {
namespace {

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

// Irradiance 11.4, gain 8.8 and exposure 16.16 make a shade of 15 fraction bits, rounded; so does the highlight, in
// 1/128.
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
    const auto lit_by = [&](std::uint32_t irradiance) {
      const std::int64_t product = std::int64_t{irradiance} * entry.gain() * exposure;
      return std::min<std::int64_t>(reference::nearest(product, 1 << 13), 8 << 15);
    };
    const std::array<std::int64_t, 3> lit{lit_by(light), lit_by(light / 2), lit_by(0)};
    const std::int64_t highlight =
        length < 1022 ? 0 : reference::nearest(std::int64_t{entry.specular} * reflectance(map.data(), gradient), 128);
    const Colour12 got = illuminated(entry, {light, light / 2, 0}, exposure, gradient, map.data());
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int64_t sum = entry.colour[c] * (lit[c] + entry.ambient * 256) + 4095 * highlight;
      ASSERT_EQ(got[c], std::min<std::int64_t>(reference::nearest(sum, 1 << 15), 4095));
    }
  }
  wire::SegmentationEntry white;
  white.colour = {4095, 4095, 4095};
  white.set_gain(256);
  EXPECT_EQ(illuminated(white, {8, 8, 8}, 65536, {}, map.data()), (Colour12{2048, 2048, 2048})) << "2047.5 rounded up";
  white.set_gain(1);
  EXPECT_EQ(illuminated(white, {9, 9, 9}, 4096, {}, map.data()), (Colour12{1, 1, 1}))
      << "a shade of 4.5 is 5: 0.62 units";
}

}  // namespace
}  // namespace gicube::emu
