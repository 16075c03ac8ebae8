#include "encode/look_up_tables.h"

#include "test.h"

namespace gicube {
namespace {

TEST(SegmentationLut, ADensityStandsForItsValue) {
  const TransferFunction f{{{-1000, {0, 0.5, 1}}, {3095, {1, 0.5, 0}}}, {{-1000, 0}, {3095, 1}}};
  const auto entries = segmentation_entries(f, {-1000, 3095}, {});
  ASSERT_EQ(entries.size(), 4096u);
  for (std::uint16_t d = 0; d <= 4095; ++d) {
    EXPECT_EQ(entries[d].colour, (std::array<std::uint16_t, 3>{d, 2048, static_cast<std::uint16_t>(4095 - d)}));
    EXPECT_EQ(entries[d].opacity, (65535 * d + 2047) / 4095) << d;
  }
}

TEST(SegmentationLut, AStepAtAWholeDensityTakesItsSecondSideThere) {
  for (int step = 1; step < 4095; step += 13) {
    const double value = step;
    const TransferFunction f{{{0, {}}}, {{value, 0}, {value, 1}}};
    const auto entries = segmentation_entries(f, {0, 4095}, {});
    const auto at = static_cast<std::size_t>(step);
    EXPECT_EQ(entries[at - 1].opacity, 0) << step;
    EXPECT_EQ(entries[at].opacity, 65535) << step;
  }
}

TEST(SegmentationLut, OpacityOneIsFullScaleAndDustIsInvisible) {
  const auto opacity = [](double alpha) {
    return segmentation_entries({{{0, {}}}, {{0, alpha}}}, {0, 1}, {})[0].opacity;
  };
  EXPECT_EQ(opacity(1), 65535);
  EXPECT_EQ(opacity(0.5), 32768);
  EXPECT_EQ(opacity(1.0 / 65535), 1);
  EXPECT_EQ(opacity(0.51 / 65535), 1);
  EXPECT_EQ(opacity(0.49 / 65535), 0);
}

TEST(SegmentationLut, TheWideDatapathGetsTwelveFurtherBitsAndNothingElseChanges) {
  const auto entry = [](double alpha, bool wide) {
    return segmentation_entries({{{0, {}}}, {{0, alpha}}}, {0, 1}, {}, wide)[0];
  };
  for (const double alpha : {0.0, 1e-9, 1e-7, 0.49 / 65535, 0.5 / 65535, 0.51 / 65535, 0.3, 1 - 1e-7, 1.0}) {
    EXPECT_EQ(entry(alpha, true).opacity, entry(alpha, false).opacity) << alpha;
    EXPECT_EQ(entry(alpha, false).opacity_fine, 0) << alpha;
    // Half a unit, or a whole one where the word ends.
    EXPECT_NEAR(entry(alpha, true).wide_opacity(), alpha, 1.01 / 65535 / wire::kFineOpacityOne) << alpha;
  }
  EXPECT_EQ(entry((100 + 10.7 / 4096) / 65535, true).opacity_fine, 11);
  EXPECT_EQ(entry((100 - 10.7 / 4096) / 65535, true).opacity_fine, -11);
  EXPECT_EQ(entry(1, true).wide_opacity(), 1);
  EXPECT_LT(entry(1 - 1e-7, true).wide_opacity(), 1);
  EXPECT_EQ(entry(1e-9, true).wide_opacity(), 0);
  EXPECT_GT(entry(4e-9, true).wide_opacity(), 0);
}

TEST(SegmentationLut, ShadingCoefficientsAreIn128ths) {
  const TransferFunction f{{{0, {}}}, {{0, 0}}};
  const auto entry = [&f](Phong phong) { return segmentation_entries(f, {0, 1}, phong)[4095]; };
  EXPECT_EQ(entry({0.25, 0.7, 0.35, 24}).ambient, 32);
  EXPECT_EQ(entry({0.25, 0.7, 0.35, 24}).knee, 122);  // 121.6
  EXPECT_EQ(entry({0.25, 0.7, 0.35, 24}).reflect, 128);
  EXPECT_EQ(entry({1.99, 0, 0, 1}).ambient, 255);
  EXPECT_EQ(entry({1.0, 0.99, 0, 1}).knee, 255);
  EXPECT_EQ(entry({0, 0, 0, 1}).knee, 0);
}

TEST(SegmentationLut, GainsTurnWhatWasAbsorbedIntoWhatFellOnASampleAndAreOneIfTheWordsHoldThat) {
  const TransferFunction f{{{0, {}}}, {{0, 0.25}}};
  auto entries = segmentation_entries(f, {0, 1}, {});
  set_gains(entries, {0.5, 0.5, 0.5});
  EXPECT_EQ(entries[7].gain(), 8u << wire::kGainFractionBits);
  set_unit_gains(entries);
  EXPECT_EQ(entries[7].gain(), 1u << wire::kGainFractionBits);
  EXPECT_EQ(entries[7].ambient, 0);
  EXPECT_EQ(entries[7].opacity, 16384);
}

TEST(SegmentationLut, OfColoursThatAreScatteredMoreTheGainIsGreaterAndOthersGetLessOfTheirFactor) {
  const TransferFunction f{{{0, {1, 1, 0.5}}}, {{0, 0.25}}};
  auto entries = segmentation_entries(f, {0, 1}, {});
  const auto before = entries[7].colour;
  set_gains(entries, {0.5, 0.75, 1});
  EXPECT_EQ(entries[7].gain(), 65535u) << "of blue nothing is absorbed";
  EXPECT_EQ(entries[7].colour[2], before[2]);
  set_gains(entries = segmentation_entries(f, {0, 1}, {}), {0.5, 0.75, 0});
  EXPECT_EQ(entries[7].gain(), 16u << wire::kGainFractionBits);
  EXPECT_EQ(entries[7].colour[1], before[1]);
  EXPECT_NEAR(entries[7].colour[0], before[0] / 2.0, 0.5);
  EXPECT_NEAR(entries[7].colour[2], before[2] / 4.0, 0.5);
}

TEST(SegmentationLut, GainsOfIrradianceLeaveNoAmbientAndAWholeHighlight) {
  const TransferFunction f{{{0, {1, 1, 1}}}, {{0, 0.5}}};
  auto entries = segmentation_entries(f, {0, 4095}, {.ambient = 0.5, .diffuse = 0.25});
  ASSERT_EQ(entries[7].ambient, 64);
  set_gains(entries, {});
  EXPECT_EQ(entries[7].ambient, 0);
  EXPECT_EQ(entries[7].specular, 128);
}

}  // namespace
}  // namespace gicube
