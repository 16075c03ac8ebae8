// The colour of samples whose voxels have colours, against real numbers.
#include "datapath/tint.h"

#include "test.h"

namespace gicube::emu {
namespace {

TEST(Tint, OfFullColourLeavesTheEntryAndOfNoneMakesItBlack) {
  wire::SegmentationEntry entry;
  entry.opacity = 777;
  entry.ambient = 12;
  for (const int value : {0, 1, 2047, 4094, 4095}) {
    entry.colour = {static_cast<std::uint16_t>(value), 4095, 5};
    EXPECT_EQ(tinted(entry, {4095, 4095, 4095}), entry);
    const wire::SegmentationEntry black = tinted(entry, {0, 0, 0});
    EXPECT_EQ(black.colour, (std::array<std::uint16_t, 3>{0, 0, 0}));
    EXPECT_EQ(black.opacity, 777);
    EXPECT_EQ(black.ambient, 12);
  }
}

TEST(Tint, IsTheRoundedProduct) {
  wire::SegmentationEntry entry;
  for (int a = 0; a <= 4095; a += 13) {
    for (int b = 0; b <= 4095; b += 17) {
      entry.colour = {static_cast<std::uint16_t>(a), 0, 0};
      ASSERT_EQ(tinted(entry, {b, 0, 0}).colour[0], std::lround(a * b / 4095.0)) << a << " x " << b;
    }
  }
}

TEST(ColourOfWords, RoundsTheThreeFractionBitsAway) {
  EXPECT_EQ(colour_of_words({0, 3, 4, 0}, false), (Colour12{0, 0, 1}));
  EXPECT_EQ(colour_of_words({32760, 32755, 16380, 0}, false), (Colour12{4095, 4094, 2048}));
}

TEST(ColourOfWords, DividesPremultipliedOnesByTheirAlpha) {
  for (int alpha = 1; alpha <= 32760; alpha += 97) {
    for (const double colour : {0.0, 0.1, 0.5, 0.9, 1.0}) {
      const auto word = static_cast<std::int16_t>(std::lround(alpha * colour));
      const Colour12 found =
          colour_of_words({word, static_cast<std::int16_t>(alpha), 0, static_cast<std::int16_t>(alpha)}, true);
      ASSERT_EQ(found[0], std::lround(4095.0 * word / alpha)) << alpha;
      ASSERT_EQ(found[1], 4095) << "of alpha's size: it is full";
    }
  }
}

TEST(ColourOfWords, StaysWithinOneWhereRoundingHasLeftMoreThanAlpha) {
  EXPECT_EQ(colour_of_words({5, 8, 9, 8}, true), (Colour12{2559, 4095, 4095}));
}

TEST(ColourOfWords, OfNoAlphaIsBlack) { EXPECT_EQ(colour_of_words({0, 0, 0, 0}, true), Colour12{}); }

}  // namespace
}  // namespace gicube::emu
