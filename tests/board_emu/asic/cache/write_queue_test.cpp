#include "asic/cache/write_queue.h"

#include "config/config.h"
#include "cycle/memory_port.h"
#include "cycle/splat_unit.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(WriteQueue, AsksForWhatWaitsOnceHalfOfItsPlacesAreTaken) {
  WriteQueue writes(32);
  for (std::uint32_t tile = 0; tile < 15; ++tile) writes.put(0, tile, true);
  writes.ask(5, false);
  EXPECT_TRUE(writes.all_sent());
  writes.put(0, 15, true);
  writes.ask(6, false);
  EXPECT_FALSE(writes.all_sent());
  EXPECT_EQ(writes.next().asked, 6u);
  EXPECT_EQ(writes.room(), 16u);
}

TEST(WriteQueue, AsksForAllWhenToldTo) {
  WriteQueue writes(32);
  writes.put(3, 7, true);
  writes.ask(9, true);
  ASSERT_FALSE(writes.all_sent());
  EXPECT_EQ(writes.next().block, 3u);
  EXPECT_EQ(writes.next().tile, 7u);
  EXPECT_FALSE(writes.next().fetch);
}

TEST(WriteQueue, WritesATileThatChangesAgainWhileItWaitsOnce) {
  WriteQueue writes(32);
  writes.put(1, 2, true);
  writes.put(1, 2, true);
  writes.put(2, 2, true);
  EXPECT_EQ(writes.size(), 2u);
  EXPECT_EQ(writes.counters().tiles, 3u);
  EXPECT_EQ(writes.counters().combined, 1u);
  writes.ask(0, true);
  writes.put(1, 2, true);  // the former is on its way
  EXPECT_EQ(writes.size(), 3u);
}

TEST(WriteQueue, FetchesATileThatTheCacheHasLostBeforeItIsWritten) {
  WriteQueue writes(32);
  writes.put(1, 2, false);
  writes.ask(0, true);
  EXPECT_TRUE(writes.next().fetch);
  writes.send(1);
  EXPECT_FALSE(writes.next().fetch);
  EXPECT_EQ(writes.next().tile, 2u);
  EXPECT_EQ(writes.counters().fetches, 1u);
}

TEST(WriteQueue, APlaceIsFreeInTheCycleAfterItsTileWasSent) {
  WriteQueue writes(32);
  writes.put(0, 0, true);
  writes.ask(0, true);
  writes.send(4);
  writes.settle(4);
  EXPECT_EQ(writes.room(), 31u);
  EXPECT_FALSE(writes.empty());
  writes.settle(5);
  EXPECT_EQ(writes.room(), 32u);
  EXPECT_TRUE(writes.empty());
}

TEST(MemoryPort, ServesReadsAndWritesInTheOrderInWhichTheyWereAskedAndAReadFirstInOneCycle) {
  MissQueue misses(32);
  WriteQueue writes(32);
  const v1::BoardConfig config = resolve(v1::BoardConfig());
  MemoryPort port(config, {{&misses, &writes}}, 1);
  writes.put(0, 40, true);
  writes.ask(9, true);
  misses.ask(10, 0, 0);
  writes.put(0, 41, true);
  writes.ask(10, true);
  EXPECT_FALSE(port.tick(9));
  EXPECT_TRUE(port.tick(10));
  EXPECT_EQ(port.channel().counters().packets_written, 1u);
  EXPECT_TRUE(port.tick(11));
  EXPECT_TRUE(misses.all_sent());
  EXPECT_EQ(misses.oldest().sent, 11u);
  EXPECT_EQ(port.channel().counters().packets_written, 1u);
  EXPECT_TRUE(port.tick(12));
  EXPECT_EQ(port.channel().counters().packets_written, 2u);
  EXPECT_FALSE(port.tick(13));
}

TEST(MemoryPort, ServingAheadSendsEachRequestInTheSameCycle) {
  for (const bool ahead : {false, true}) {
    MissQueue misses(32);
    WriteQueue writes(32);
    MemoryPort port(resolve(v1::BoardConfig()), {{&misses, &writes}}, 1);
    writes.put(0, 40, false);
    writes.ask(3, true);
    misses.ask(3, 0, 1);
    misses.ask(3, 0, 2);
    for (Cycle now = 3; now < 10; ++now) ahead ? port.tick_ahead(now) : port.tick(now);
    misses.take();
    EXPECT_EQ(misses.oldest().sent, 5u) << ahead;  // reads in cycles 4 and 5, fetch and write in 6 and 7
    writes.settle(7);
    EXPECT_FALSE(writes.empty()) << ahead;
    writes.settle(8);
    EXPECT_TRUE(writes.empty()) << ahead;
  }
}

TEST(SplatUnit, TakesTheCacheForTwoCyclesADeposit) {
  SplatUnit unit(4);
  unit.add().tiles = 3;
  EXPECT_FALSE(unit.busy(10));
  unit.begin(10);
  EXPECT_TRUE(unit.takes_cache(10));
  EXPECT_TRUE(unit.takes_cache(11));
  EXPECT_FALSE(unit.takes_cache(12));
  EXPECT_EQ(unit.counters().deposits, 1u);
}

TEST(SplatUnit, OfTwoPortsTakesOneForACycleAndThenTheOther) {
  SplatUnit unit(4, 2);
  unit.add().tiles = 3;
  unit.begin(10);
  EXPECT_TRUE(unit.takes_cache(10));
  EXPECT_FALSE(unit.takes_write_port(10));
  EXPECT_FALSE(unit.takes_cache(11));
  EXPECT_TRUE(unit.takes_write_port(11));
  EXPECT_FALSE(unit.takes_write_port(12));
}

TEST(SplatUnit, IsBusyUntilItsLastCarrierIsSent) {
  SplatUnit unit(4);
  Splat& splat = unit.add();
  splat.carriers = 2;  // and nothing for this block's own words
  splat.carrier[0].ray = 7;
  splat.carrier[1].ray = 8;
  unit.begin(10);
  EXPECT_FALSE(unit.takes_cache(10));
  EXPECT_TRUE(unit.busy(11));
  EXPECT_EQ(unit.carrier().ray, 7u);
  unit.sent_carrier();
  EXPECT_EQ(unit.carrier().ray, 8u);
  unit.sent_carrier();
  EXPECT_FALSE(unit.busy(11));
  EXPECT_EQ(unit.counters().carriers, 2u);
}

}  // namespace
}  // namespace gicube::emu
