#include "encode/volume/samples.h"

#include "test.h"
#include "test_volume.h"

namespace gicube {
namespace {

using Densities = std::vector<std::uint16_t>;

TEST(Density, ByteRangeMapsToTheWholeOfTwelveBits) {
  const TestVolume<std::uint8_t> volume({2, 2, 2}, SampleType::kUint8, [](int x, int y, int z) {
    const int index = x + 2 * y + 4 * z;
    return std::array{0, 1, 2, 127, 128, 200, 254, 255}[static_cast<std::size_t>(index)];
  });
  // 4095 / 255 = 16.0588...
  EXPECT_EQ(to_densities(volume.view(), {0, 255}), (Densities{0, 16, 32, 2039, 2056, 3212, 4079, 4095}));
}

TEST(Density, TwelveBitValuesStayThemselves) {
  const TestVolume<std::uint16_t> volume({64, 64, 2}, SampleType::kUint12,
                                         [](int x, int y, int z) { return (x + 64 * y + 2048 * z) % 4096; });
  EXPECT_EQ(to_densities(volume.view(), {0, 4095}), volume.samples);
}

TEST(Density, BeyondTheRangeIsClamped) {
  const TestVolume<std::int16_t> volume({4, 2, 2}, SampleType::kInt16, [](int x, int, int) {
    return std::array{-32768, -1000, 1000, 32767}[static_cast<std::size_t>(x)];
  });
  const Densities densities = to_densities(volume.view(), {-1000, 1000});
  EXPECT_EQ(Densities(densities.begin(), densities.begin() + 4), (Densities{0, 0, 4095, 4095}));
}

// The formula of volume.h by the standard library's own rounding.
std::uint16_t expected_density(double value, ValueRange range) {
  const double density = 4095 * (value - range.low) / (range.high - range.low);
  return static_cast<std::uint16_t>(std::lround(std::fmin(std::fmax(density, 0), 4095)));
}

TEST(Density, EveryTypeFollowsTheFormula) {
  const ValueRange range{-300.5, 12345.25};
  const auto value = [](int x, int y, int z) { return (x * 7919 + y * 104729 + z * 1299709) % 15000 - 1000; };
  const auto expect_formula = [&](const auto& volume) {
    const Densities densities = to_densities(volume.view(), range);
    for (std::size_t i = 0; i < densities.size(); ++i) {
      ASSERT_EQ(densities[i], expected_density(static_cast<double>(volume.samples[i]), range)) << volume.samples[i];
    }
  };
  expect_formula(TestVolume<std::uint8_t>({9, 8, 7}, SampleType::kUint8, value));
  expect_formula(TestVolume<std::uint16_t>({9, 8, 7}, SampleType::kUint16, value));
  expect_formula(TestVolume<std::int16_t>({9, 8, 7}, SampleType::kInt16, value));
  expect_formula(TestVolume<float>({9, 8, 7}, SampleType::kFloat32, value));
}

TEST(Density, ATieRoundsUp) {
  const TestVolume<float> volume({2, 2, 2}, SampleType::kFloat32, [](int x, int, int) { return x == 0 ? 2003 : 2005; });
  const Densities densities = to_densities(volume.view(), {0, 8190});
  EXPECT_EQ(densities[0], 1002);
  EXPECT_EQ(densities[1], 1003);
}

TEST(Density, FloatsRoundAsTheFormulaAlsoBesideTies) {
  const ValueRange range{-3.7, 911.3};
  const auto value = [&](int x, int y, int z) {
    const double half = ((x + 16 * (y + 16 * z)) * 2 + 1) % 8190 / 2.0;  // beside it, at most three numbers away
    auto near = static_cast<float>(range.low + half * (range.high - range.low) / 4095);
    for (int i = 0; i < x % 4; ++i) near = std::nextafter(near, y % 2 == 0 ? 1e9F : -1e9F);
    return near;
  };
  const TestVolume<float> volume({16, 16, 16}, SampleType::kFloat32, value);
  const Densities densities = to_densities(volume.view(), range);
  for (std::size_t i = 0; i < densities.size(); ++i) {
    ASSERT_EQ(densities[i], to_density(double{volume.samples[i]}, range)) << volume.samples[i];
  }
}

TEST(Density, SamplesNeedNotBeAligned) {
  const TestVolume<float> volume({2, 2, 2}, SampleType::kFloat32,
                                 [](int x, int y, int z) { return x + 2 * y + 4 * z; });
  std::vector<std::byte> shifted(volume.samples.size() * sizeof(float) + 1);
  std::memcpy(shifted.data() + 1, volume.samples.data(), shifted.size() - 1);
  VolumeView view = volume.view();
  view.samples = std::span(shifted).subspan(1);
  EXPECT_EQ(to_densities(view, {0, 7}), (Densities{0, 585, 1170, 1755, 2340, 2925, 3510, 4095}));
}

}  // namespace
}  // namespace gicube
