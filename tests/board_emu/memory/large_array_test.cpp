#include "memory/large_array.h"

#include "test.h"

namespace gicube::emu {
namespace {

std::uintptr_t address(const LargeArray<std::int16_t>& array) { return reinterpret_cast<std::uintptr_t>(array.data()); }

TEST(LargeArray, BeginsAtAHugePageIfItFillsOne) {
  for (const std::size_t bytes : {kHugePage, kHugePage + 2, 3 * kHugePage - 2}) {
    EXPECT_EQ(address(LargeArray<std::int16_t>(bytes / 2)) % kHugePage, 0u) << bytes;
  }
}

TEST(LargeArray, HoldsWhatIsWrittenWhereverItsSizeLies) {
  for (const std::size_t count : {std::size_t{1}, kHugePage / 2 - 1, kHugePage / 2, kHugePage + 1}) {
    LargeArray<std::int16_t> array(count);
    for (std::size_t i = 0; i < count; ++i) array[i] = static_cast<std::int16_t>(i);
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(array[i], static_cast<std::int16_t>(i));
  }
}

TEST(LargeArray, KeepsItsElementsWhenItGrowsBeyondAHugePage) {
  LargeArray<std::int16_t> array(1000, 7);
  array.resize(kHugePage, 8);
  for (std::size_t i = 0; i < array.size(); ++i) ASSERT_EQ(array[i], i < 1000 ? 7 : 8);
  EXPECT_EQ(address(array) % kHugePage, 0u);
}

TEST(LargeArray, LeavesUnwrittenWhatHasNoValue) {
  LargeArray<std::int16_t> array(1000, 7);
  array.resize(10);
  array.resize(1000);
  EXPECT_EQ(array[999], 7);
}

}  // namespace
}  // namespace gicube::emu
