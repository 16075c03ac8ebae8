#include "board/timeline.h"

#include "test.h"

namespace gicube::emu {
namespace {

constexpr Picoseconds kClock = 30'000;    // PCI
constexpr Picoseconds kDspCycle = 5'000;  // 200 MHz

Timeline pci_timeline() { return Timeline(BusTiming(v1::BusConfig{}), 200'000); }

TEST(Clock, TurnsCyclesIntoPicosecondsWithoutOverflow) {
  EXPECT_EQ(cycles_to_ps(3, 200'000), 15'000u);
  EXPECT_EQ(cycles_to_ps(1, 33'333), 30'000u);  // 30000.3, to the picosecond below
  EXPECT_EQ(cycles_to_ps(200'000'000'000'000, 200'000), 1'000'000'000'000'000'000u);  // 11.6 days
}

TEST(Timeline, TakesATransactionDownTheBusThroughTheDspAndUp) {
  Timeline timeline = pci_timeline();
  timeline.add(100, 1, {.down_bytes = 4 * 8, .dsp = true, .dsp_cycles = 50, .up_bytes = 4 * 16, .watched = true});
  EXPECT_EQ(timeline.finish(1), 100 + 11 * kClock + 50 * kDspCycle + 19 * kClock);
  EXPECT_EQ(timeline.dsp_busy_ps(), 50 * kDspCycle);
}

TEST(Timeline, ServesTheDspsTransactionsInTheOrderOfTheirArrival) {
  Timeline timeline = pci_timeline();
  timeline.add(0, 1, {.down_bytes = 4, .dsp = true, .dsp_cycles = 1000, .watched = true});
  timeline.add(0, 2, {.down_bytes = 4, .dsp = true, .dsp_cycles = 10, .watched = true});
  EXPECT_EQ(timeline.finish(2), 4 * kClock + 1010 * kDspCycle);
  const auto finished = timeline.take_finished();
  ASSERT_EQ(finished.size(), 2u);
  EXPECT_EQ(finished[0].id, 1u);
  EXPECT_EQ(finished[0].time_ps, 4 * kClock + 1000 * kDspCycle);
  EXPECT_EQ(finished[1].id, 2u);
}

TEST(Timeline, OverlapsTheNextUploadWithTheDspsWork) {
  Timeline timeline = pci_timeline();
  timeline.add(0, 1, {.down_bytes = 4 * 256, .dsp = true, .dsp_cycles = 100'000, .watched = true});
  timeline.add(0, 2, {.down_bytes = 4 * 256, .dsp = true, .dsp_cycles = 100'000, .watched = true});
  EXPECT_EQ(timeline.finish(2), 259 * kClock + 200'000 * kDspCycle);
}

TEST(Timeline, LetsNothingFinishInTheFuture) {
  Timeline timeline = pci_timeline();
  timeline.add(0, 1, {.down_bytes = 4, .dsp = true, .dsp_cycles = 1000, .watched = true});
  const Picoseconds end = 4 * kClock + 1000 * kDspCycle;
  timeline.advance(end - 1);
  EXPECT_TRUE(timeline.take_finished().empty());
  timeline.advance(end);
  ASSERT_EQ(timeline.take_finished().size(), 1u);
}

TEST(Timeline, DoesNotDependOnWhenItIsAskedToAdvance) {
  Picoseconds ends[2];
  for (const bool often : {false, true}) {
    Timeline timeline = pci_timeline();
    for (std::uint64_t i = 1; i <= 20; ++i) {
      const Picoseconds stamp = i * 1'000'000;
      if (often) {
        for (Picoseconds t = timeline.now(); t < stamp; t += 12'345) timeline.advance(t);
      }
      timeline.add(stamp, i,
                   {.down_bytes = 4 * 100 * i, .dsp = true, .dsp_cycles = 77 * i, .up_bytes = 4000, .watched = true});
    }
    ends[often ? 1 : 0] = timeline.finish(20);
  }
  EXPECT_EQ(ends[0], ends[1]);
}

TEST(Timeline, ReportsOnlyWatchedTransactions) {
  Timeline timeline = pci_timeline();
  timeline.add(0, 1, {.down_bytes = 4});
  timeline.advance(1'000'000);
  EXPECT_TRUE(timeline.take_finished().empty());
}

TEST(Timeline, StopsAtADeadlineAndGoesOnFromThere) {
  Timeline timeline = pci_timeline(), other = pci_timeline();
  const BusTransaction transaction{
      .down_bytes = 4 * 8, .dsp = true, .dsp_cycles = 50, .up_bytes = 4 * 16, .watched = true};
  timeline.add(100, 1, transaction);
  other.add(100, 1, transaction);
  const Picoseconds end = other.finish(1);
  EXPECT_EQ(timeline.finish(1, end - 1), std::nullopt);
  EXPECT_EQ(timeline.now(), end - 1);
  EXPECT_EQ(timeline.finish(1, end), end);
}

TEST(Timeline, ATransactionThatIsTakenBackCostsTheDspNothingAndOneWordGoesUp) {
  Timeline timeline = pci_timeline();
  const BusTransaction transaction{
      .down_bytes = 4, .dsp = true, .dsp_cycles = 1000, .up_bytes = 4 * 16, .watched = true};
  timeline.add(0, 1, transaction);
  timeline.add(0, 2, transaction);
  timeline.add(0, 3, transaction);
  EXPECT_TRUE(timeline.take_back(20 * kClock, 2));
  EXPECT_FALSE(timeline.take_back(20 * kClock, 1));  // its turn has begun
  EXPECT_FALSE(timeline.take_back(20 * kClock, 7));
  const Picoseconds first = 4 * kClock + 1000 * kDspCycle;
  EXPECT_EQ(timeline.finish(1), first + 19 * kClock);
  EXPECT_EQ(timeline.finish(2), first + 19 * kClock + 4 * kClock);
  EXPECT_EQ(timeline.finish(3), first + 1000 * kDspCycle + 19 * kClock);
  EXPECT_EQ(timeline.dsp_busy_ps(), 2000 * kDspCycle);
}

TEST(Timeline, ATransactionOnItsWayDownCanBeTakenBackToo) {
  Timeline timeline = pci_timeline();
  timeline.add(0, 1, {.down_bytes = 4 * 1024, .dsp = true, .dsp_cycles = 1000, .up_bytes = 64, .watched = true});
  EXPECT_TRUE(timeline.take_back(kClock, 1));
  timeline.finish(1);
  EXPECT_EQ(timeline.dsp_busy_ps(), 0u);
}

}  // namespace
}  // namespace gicube::emu
