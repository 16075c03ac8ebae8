#include "gicube/wire/lut.h"

#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(SegmentationWord, HasTheBytesThatItsTableSays) {
  SegmentationEntry entry;
  entry.colour = {0xABC, 0xDEF, 0x123};  // nibbles, low one first: C B A  F E D  3 2 1
  entry.opacity = 0x4567;                // 7 6 5 4
  entry.ambient = 0x89;                  // 9 8
  entry.reflect = kShadeOne;             // 0 8
  entry.knee = 0x6D;                     // D 6, then 0 to the end of the third dword
  EXPECT_EQ(hex_of<kSegmentationEntryBytes>(entry), "BC FA DE 23 71 56 94 08 D8 06 00 00");
}

RC_GTEST_PROP(SegmentationWord, ComesBackAsItWas, ()) {
  const SegmentationEntry entry = any_segmentation();
  RC_ASSERT(decode<SegmentationEntry>(encoded<kSegmentationEntryBytes>(entry)) == entry);
}

TEST(GradientWord, HasTheBitsThatItsTableSays) {
  // 511 = 0x1FF; -511 = 1024 - 511 = 0x201, << 10 = 0x80400; -1 = 0x3FF, << 20 = 0x3FF00000
  EXPECT_EQ(to_word(GradientEntry{511, -511, -1}), 0x3FF8'05FFu);
  EXPECT_EQ(to_gradient(0x3FF8'05FF), (GradientEntry{511, -511, -1}));
}

RC_GTEST_PROP(GradientWord, ComesBackAsItWas, ()) {
  GradientEntry gradient;
  for (auto& g : gradient) g = static_cast<std::int16_t>(*rc::gen::inRange(-512, 512));
  RC_ASSERT(to_gradient(to_word(gradient)) == gradient);
}

TEST(Tables, HaveThePapersBits) {
  EXPECT_EQ(kSegmentationEntries, std::size_t{kTags} * (kDensityMax + 1));  // index = tag, density
  EXPECT_EQ(kSegmentationEntries * 84, 1'376'256u);                         // [P Table 1] 5.3 Mb on four processors
  EXPECT_EQ(kReflectanceBytes, 98'304u);                                    // 0.75 Mb, 3 Mb on four
  EXPECT_EQ(kGradientCodes, 1u << 11);
}

}  // namespace
}  // namespace gicube::wire
