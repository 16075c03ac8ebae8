#include "gicube/wire/voxel.h"

#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"
#include "test.h"

namespace gicube::wire {
namespace {

TEST(Voxel, PairHasTheBytesThatItsTableSays) {
  // 0xABC + (0x555 << 12 = 0x555000) + (2 << 23 = 0x1000000) + (0x2AA << 25 = 0x554000000)
  const Voxel even{0xABC, 0x555, 2, 0x2AA};
  ASSERT_EQ(to_word(even), 0x5'5555'5ABCu);
  // 0x123 + (3 << 23 = 0x1800000) + (0x7FF << 25 = 0xFFE000000)
  const Voxel odd{0x123, kNoGradient, 3, 0x7FF};
  ASSERT_EQ(to_word(odd), 0xF'FF80'0123u);
  // Nibbles, low one first: C B A 5 5 5 5 5 5, then 3 2 1 0 0 8 F F F.
  std::array<std::uint8_t, 9> bytes;
  bytes.fill(0xEE);
  store36(bytes, 0, to_word(even));
  store36(bytes, 1, to_word(odd));
  EXPECT_EQ(to_hex(bytes), "BC 5A 55 55 35 12 00 F8 FF");
}

TEST(Voxel, PackedWordsTakeHalfBytesUpToAWholeOne) {
  EXPECT_EQ(packed36_bytes(0), 0u);
  EXPECT_EQ(packed36_bytes(1), 5u);
  EXPECT_EQ(packed36_bytes(2), 9u);
  EXPECT_EQ(packed36_bytes(3), 14u);
  EXPECT_EQ(packed36_bytes(std::size_t{256} * 256 * 256), 75'497'472u);  // a 256^3 volume
}

RC_GTEST_PROP(Voxel, ComesBackFromItsWord, ()) {
  const Voxel voxel = any_voxel();
  RC_ASSERT(to_word(voxel) < std::uint64_t{1} << 36);
  RC_ASSERT(to_voxel(to_word(voxel)) == voxel);
}

RC_GTEST_PROP(Voxel, WordsOfAStreamDoNotDisturbEachOther, ()) {
  std::vector<std::uint64_t> words(*rc::gen::inRange<std::size_t>(1, 20));
  for (auto& word : words) word = any_bits<std::uint64_t>(36);
  std::vector<std::uint8_t> bytes(packed36_bytes(words.size()));
  // Written twice, backwards: a store must replace what stood there, and only that.
  for (const bool final : {false, true}) {
    for (std::size_t i = words.size(); i-- > 0;) store36(bytes, i, final ? words[i] : ~words[i]);
  }
  for (std::size_t i = 0; i < words.size(); ++i) RC_ASSERT(load36(bytes, i) == words[i]);
}

TEST(Pixel, HasItsColoursInOrderAndAlphaOnTop) {
  EXPECT_EQ(to_word(Pixel{0x11, 0x22, 0x33, 0xABC}), 0xA'BC33'2211u);
  EXPECT_EQ(to_pixel(0xA'BC33'2211u), (Pixel{0x11, 0x22, 0x33, 0xABC}));
}

}  // namespace
}  // namespace gicube::wire
