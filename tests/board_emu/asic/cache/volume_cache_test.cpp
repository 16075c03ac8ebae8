#include "asic/cache/volume_cache.h"

#include <gtest/gtest.h>

#include "asic/cache/miss_queue.h"

namespace gicube::emu {
namespace {

using Voxel = std::array<std::uint32_t, 3>;

TEST(VolumeCache, AColdNeighbourhoodTakesTwoToEightTilesByItsParity) {
  VolumeCache cache({.block_voxels = 32});
  EXPECT_EQ(cache.check(0, Voxel{0, 0, 0}).count, 2u);    // one tile a slice
  EXPECT_EQ(cache.check(0, Voxel{5, 10, 10}).count, 4u);  // odd x: two
  EXPECT_EQ(cache.check(0, Voxel{20, 7, 20}).count, 4u);
  EXPECT_EQ(cache.check(0, Voxel{11, 21, 30}).count, 8u);
}

TEST(VolumeCache, TilesAreNumberedWithXFastest) {
  VolumeCache cache({.block_voxels = 32});
  const Misses& misses = cache.check(0, Voxel{3, 4, 5});
  ASSERT_EQ(misses.count, 4u);
  EXPECT_EQ(misses.tiles[0], (5u * 17 + 2) * 17 + 1);
  EXPECT_EQ(misses.tiles[1], (5u * 17 + 2) * 17 + 2);
  EXPECT_EQ(misses.tiles[2], (6u * 17 + 2) * 17 + 1);
  EXPECT_EQ(misses.tiles[3], (6u * 17 + 2) * 17 + 2);
}

TEST(VolumeCache, TheSecondSampleInANeighbourhoodHitsWholly) {
  VolumeCache cache({.block_voxels = 32});
  cache.check(3, Voxel{7, 7, 7});
  EXPECT_EQ(cache.check(3, Voxel{7, 7, 7}).count, 0u);
  EXPECT_EQ(cache.counters().misses[8], 1u);
  EXPECT_EQ(cache.counters().misses[0], 1u);
}

TEST(VolumeCache, AStepAlongZMissesTheFourVoxelsOfOneSlice) {
  VolumeCache cache({.block_voxels = 32});
  cache.check(0, Voxel{2, 2, 2});
  EXPECT_EQ(cache.check(0, Voxel{2, 2, 3}).count, 1u);
  EXPECT_EQ(cache.counters().missed_voxels, 8u + 4u);
}

TEST(VolumeCache, OnlyTheLatestUsedOfTheirSetsNeedNoCheck) {
  for (const unsigned ways : {2u, 4u}) {  // with more the neighbourhood itself has several of a set
    VolumeCache cache({.block_voxels = 8, .ways = ways});
    const Voxel here{3, 5, 2};
    EXPECT_FALSE(cache.latest(1, here));
    cache.check(1, here);
    EXPECT_TRUE(cache.latest(1, here));
    cache.check(2, here);  // the same sets
    EXPECT_FALSE(cache.latest(1, here));
    EXPECT_EQ(cache.check(1, here).count, 0u);  // but there
    EXPECT_TRUE(cache.latest(1, here));
  }
}

// The paper's §2.1: one sample a voxel over a whole block misses (n+1)^3 voxels, each once.
TEST(VolumeCache, ABlockAtOneSampleAVoxelIsFetchedOnceWithItsOverlap) {
  for (const std::uint32_t n : {8u, 16u, 32u}) {
    VolumeCache cache({.block_voxels = static_cast<int>(n)});
    for (int pass = 0; pass < 2; ++pass) {  // a second pass finds everything
      for (std::uint32_t z = 0; z < n; ++z) {
        for (std::uint32_t y = 0; y < n; ++y) {
          for (std::uint32_t x = 0; x < n; ++x) cache.check(9, Voxel{x, y, z});
        }
      }
    }
    EXPECT_EQ(cache.counters().filled_voxels, (n + 1) * (n + 1) * (n + 1));
    EXPECT_EQ(cache.counters().packets, (n / 2 + 1) * (n / 2 + 1) * (n + 1));
  }
}

TEST(VolumeCache, AnotherBlockTakesTheSamePlacesWhenDirectMapped) {
  VolumeCache cache({.block_voxels = 16});
  cache.check(1, Voxel{4, 4, 4});
  EXPECT_EQ(cache.check(2, Voxel{4, 4, 4}).count, 2u);
  EXPECT_EQ(cache.check(1, Voxel{4, 4, 4}).count, 2u);
}

TEST(VolumeCache, TwoWaysHoldTwoBlocksAndDropTheOneNotUsedForLonger) {
  VolumeCache cache({.block_voxels = 16, .ways = 2});
  cache.check(1, Voxel{4, 4, 4});
  cache.check(2, Voxel{4, 4, 4});
  EXPECT_EQ(cache.check(1, Voxel{4, 4, 4}).count, 0u);
  EXPECT_EQ(cache.check(3, Voxel{4, 4, 4}).count, 2u);  // in place of block 2
  EXPECT_EQ(cache.check(1, Voxel{4, 4, 4}).count, 0u);
  EXPECT_EQ(cache.check(2, Voxel{4, 4, 4}).count, 2u);
}

TEST(VolumeCache, ALinearCacheHoldsNeighbouringBlocksAtOnce) {
  VolumeCache cache({.block_voxels = 16, .linear = true, .blocks = {4, 4, 4}});
  cache.check(0, Voxel{4, 4, 4});
  EXPECT_EQ(cache.check(1, Voxel{4, 4, 4}).count, 2u);  // 16 voxels on along x
  EXPECT_EQ(cache.check(0, Voxel{4, 4, 4}).count, 0u);
}

TEST(VolumeCache, InvalidationForgetsAll) {
  VolumeCache cache({.block_voxels = 16});
  cache.check(0, Voxel{4, 4, 4});
  cache.invalidate();
  EXPECT_EQ(cache.check(0, Voxel{4, 4, 4}).count, 2u);
}

TEST(MissQueue, WhatIsAskedInACycleIsSentFromTheNextOn) {
  MissQueue queue(8);
  queue.ask(5, 1, 10);
  EXPECT_FALSE(queue.can_send(5));
  EXPECT_TRUE(queue.can_send(6));
}

TEST(MissQueue, KeepsTheOrderAndGivesRoomOnlyWhenAPacketIsTaken) {
  MissQueue queue(2);
  queue.ask(0, 1, 10);
  queue.ask(0, 1, 11);
  EXPECT_EQ(queue.room(), 0u);
  EXPECT_EQ(queue.next().tile, 10u);
  queue.send(6, 9, Delay::kBank);
  EXPECT_EQ(queue.next().tile, 11u);
  EXPECT_EQ(queue.oldest().arrival, 9u);
  EXPECT_EQ(queue.room(), 0u);
  queue.take();
  EXPECT_EQ(queue.room(), 1u);
  EXPECT_EQ(queue.oldest().arrival, kNoCycle);
  EXPECT_TRUE(queue.can_send(1));
}

}  // namespace
}  // namespace gicube::emu
