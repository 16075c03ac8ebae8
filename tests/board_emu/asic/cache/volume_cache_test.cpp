#include "asic/cache/volume_cache.h"

#include "asic/cache/miss_queue.h"
#include "test.h"

namespace gicube::emu {
namespace {

using Voxel = std::array<std::uint32_t, 3>;

// Whether a check would find all eight voxels.
bool has_all(VolumeCache cache, std::uint32_t block, const Voxel& voxel) {
  return cache.check(block, voxel).count == 0;
}

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

// 5 x 5 tiles a slice and 9 slices at n = 8; two ways have 113 sets.
TEST(VolumeCache, HasAPlaceForEachTileOfABlockWithItsFaces) {
  VolumeCache cache({.block_voxels = 8, .ways = 2});
  EXPECT_EQ(cache.tiles_of_block(), 225u);
  EXPECT_EQ(VolumeCache({.block_voxels = 32}).tiles_of_block(), 17u * 17 * 33);
  cache.check(0, Voxel{0, 0, 0});  // tiles 0 and 25, in sets 0 and 25
  cache.check(0, Voxel{6, 4, 4});  // tiles 113 and 138, in the same sets
  EXPECT_TRUE(cache.probe(0, 0));
  cache.check(1, Voxel{0, 0, 0});
  EXPECT_FALSE(cache.probe(0, 0));
  EXPECT_FALSE(cache.probe(0, 25));
  EXPECT_TRUE(cache.probe(0, 113));
  EXPECT_TRUE(cache.probe(0, 138));
}

TEST(VolumeCache, HoldsTheTilesThatWereAskedForAndNoOthers) {
  for (const CacheShape& shape : {CacheShape{.block_voxels = 8}, CacheShape{.block_voxels = 8, .ways = 4},
                                  CacheShape{.block_voxels = 8, .linear = true, .blocks = {2, 2, 2}}}) {
    VolumeCache cache(shape);
    const Misses misses = cache.check(3, Voxel{3, 5, 2});
    ASSERT_EQ(misses.count, 8u);
    for (std::uint32_t tile = 0; tile < cache.tiles_of_block(); ++tile) {
      const bool asked = std::find(misses.tiles.begin(), misses.tiles.begin() + 8, tile) != misses.tiles.begin() + 8;
      EXPECT_EQ(cache.probe(3, tile), asked) << tile;
      EXPECT_FALSE(cache.probe(2, tile)) << tile;
    }
  }
}

// Of 1377 places the tile (1, 3, 5) of a volume of 32 x 8 tiles a slice has 5 * 256 + 3 * 32 + 1, the first one.
TEST(VolumeCache, ALinearCacheTakesPlacesByTheAddressInTheVolume) {
  VolumeCache cache({.block_voxels = 16, .linear = true, .blocks = {4, 1, 1}});
  cache.check(0, Voxel{0, 0, 0});
  EXPECT_TRUE(cache.probe(0, 0));
  EXPECT_EQ(cache.check(0, Voxel{2, 6, 5}).count, 2u);
  EXPECT_FALSE(cache.probe(0, 0));
  EXPECT_TRUE(cache.probe(0, (5 * 9 + 3) * 9 + 1));
  EXPECT_EQ(cache.check(0, Voxel{0, 0, 0}).count, 2u);
}

// A neighbourhood of odd x and y takes one voxel of each of four tiles a slice, and of even ones all four of one.
TEST(VolumeCache, WithTagsOfVoxelsKeepsOfAPacketOnlyWhatWasAskedFor) {
  for (const bool linear : {false, true}) {
    VolumeCache cache({.block_voxels = 8, .linear = linear, .blocks = {2, 2, 2}, .tags_of_voxels = true});
    EXPECT_EQ(cache.check(0, Voxel{3, 3, 2}).count, 8u);
    EXPECT_EQ(cache.check(0, Voxel{3, 3, 2}).count, 0u);
    EXPECT_TRUE(has_all(cache, 0, Voxel{3, 3, 2}));
    EXPECT_FALSE(has_all(cache, 0, Voxel{4, 3, 2}));
    EXPECT_EQ(cache.check(0, Voxel{4, 3, 2}).count, 4u);  // packets that came before, for the voxels at x = 5
    EXPECT_EQ(cache.counters().missed_voxels, 8u + 4u);
    EXPECT_FALSE(cache.probe(0, (2 * 5 + 2) * 5 + 2));    // y = 5 was never asked for
    EXPECT_EQ(cache.check(0, Voxel{4, 4, 2}).count, 2u);  // two voxels each
    EXPECT_TRUE(cache.probe(0, (2 * 5 + 2) * 5 + 2));
    EXPECT_EQ(cache.counters().missed_voxels, 8u + 4u + 4u);
    EXPECT_EQ(cache.counters().filled_voxels, 16u);
  }
}

TEST(VolumeCache, OfATileAtABlocksFaceHoldsTheVoxelsThatThereAre) {
  VolumeCache cache({.block_voxels = 8, .blocks = {1, 1, 1}, .tags_of_voxels = true});
  cache.check(0, Voxel{7, 7, 0});
  EXPECT_TRUE(cache.probe(0, 4 * 5 + 4));
}

// 9 x 9 x 9 places; 16 voxels are a row of two blocks.
TEST(VolumeCache, WithLinearTagsOfVoxelsTakesPlacesByTheAddressInTheVolume) {
  VolumeCache cache({.block_voxels = 8, .linear = true, .blocks = {2, 2, 2}, .tags_of_voxels = true});
  cache.check(0, Voxel{0, 0, 0});
  EXPECT_EQ(cache.check(1, Voxel{0, 0, 0}).count, 2u);
  EXPECT_TRUE(has_all(cache, 0, Voxel{0, 0, 0}));
  EXPECT_TRUE(has_all(cache, 1, Voxel{0, 0, 0}));
  EXPECT_EQ(cache.check(2, Voxel{0, 5, 1}).count, 4u);  // up to voxel (1, 14, 2), at 2 * 256 + 14 * 16 + 1 = 729 + 8
  EXPECT_TRUE(has_all(cache, 0, Voxel{0, 0, 0}));
  EXPECT_FALSE(has_all(cache, 1, Voxel{0, 0, 0}));
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
  for (const CacheShape& shape : {CacheShape{.block_voxels = 16}, CacheShape{.block_voxels = 16, .ways = 2},
                                  CacheShape{.block_voxels = 16, .linear = true, .blocks = {1, 1, 1}}}) {
    VolumeCache cache(shape);
    for (const std::uint32_t at : {4u, 14u}) cache.check(0, Voxel{at, at, at});
    cache.invalidate();
    for (const std::uint32_t at : {4u, 14u}) EXPECT_EQ(cache.check(0, Voxel{at, at, at}).count, 2u);
  }
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
