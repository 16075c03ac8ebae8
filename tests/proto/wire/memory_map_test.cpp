#include "gicube/wire/memory_map.h"

#include "test.h"

namespace gicube::wire {
namespace {

constexpr std::uint64_t kTop = std::numeric_limits<std::uint64_t>::max();

TEST(MemoryMap, RegionsRiseAndDoNotOverlap) {
  for (std::size_t i = 1; i < kMemoryMap.size(); ++i) {
    EXPECT_LE(kMemoryMap[i - 1].base + kMemoryMap[i - 1].bytes, kMemoryMap[i].base) << kMemoryMap[i].name;
  }
}

TEST(MemoryMap, RegionsHoldTheirLargestContent) {
  EXPECT_EQ(kSegmentationLut.bytes, (std::uint64_t{1} << 14) * 12);
  EXPECT_EQ(kGradientLut.bytes, 2048u * 4);
  EXPECT_EQ(kReflectanceMap.bytes, 6u * 128 * 128);
  EXPECT_GE(kEmptyFlags.bytes * 8,
            std::uint64_t{1024 / 8} * (1024 / 8) * (1024 / 8));  // smallest blocks, largest volume
  EXPECT_EQ(kFramebuffer.bytes, packed36_bytes(std::size_t{kMaxImageSize} * kMaxImageSize));
  EXPECT_EQ(kVolume.bytes, packed36_bytes(std::size_t{1} << 30));
}

TEST(FindRegion, KnowsEachRegionFromItsFirstToItsLastByte) {
  for (const MemoryRegion& region : kMemoryMap) {
    EXPECT_EQ(find_region(region.base, region.bytes), &region);
    EXPECT_EQ(find_region(region.base + region.bytes - 1, 1), &region);
    EXPECT_EQ(find_region(region.base, region.bytes + 1), nullptr);
    EXPECT_EQ(find_region(region.base + region.bytes - 1, 2), nullptr);
    EXPECT_EQ(find_region(region.base + region.bytes, 1), nullptr);
    if (region.base > 0) {
      EXPECT_EQ(find_region(region.base - 1, 1), nullptr);
    }
  }
}

TEST(FindRegion, IsNotFooledByLengthsThatWrapAround) {
  EXPECT_EQ(find_region(kVolume.base, kTop), nullptr);
  EXPECT_EQ(find_region(kVolume.base + 1, kTop - kVolume.base), nullptr);
  EXPECT_EQ(find_region(kTop, 1), nullptr);
  EXPECT_EQ(find_region(kTop, kTop), nullptr);
}

}  // namespace
}  // namespace gicube::wire
