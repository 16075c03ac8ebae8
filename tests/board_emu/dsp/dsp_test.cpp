// The DSP's time against hand-worked cases.
#include "dsp/dsp.h"

#include "dsp/overflow_store.h"
#include "test.h"

namespace gicube::emu {
namespace {

using Kind = SdramUse::Kind;

constexpr DspLoop kLoop{"ten cycles", 20, 12, 8};  // 20 multiplications on two units
constexpr DspLoop kOther{"three cycles", 2, 8, 6};

v1::BoardConfig without_refresh() {
  v1::BoardConfig config;
  config.mutable_sdram()->set_refresh_interval(0);
  return config;
}

TEST(DspLoop, IsBoundByTheUnitThatHasMostToDo) {
  EXPECT_EQ((DspLoop{"", 20, 0, 0}).interval(), 10u) << "two multiply";
  EXPECT_EQ((DspLoop{"", 0, 0, 9}).interval(), 5u) << "two load or store";
  EXPECT_EQ((DspLoop{"", 0, 13, 4}).interval(), 3u) << "six others, with loads and stores";
  EXPECT_EQ((DspLoop{"", 6, 17, 1}).interval(), 3u);
  EXPECT_EQ((DspLoop{"", 7, 17, 1}).interval(), 4u) << "eight in all; seven multiplications take four cycles too";
  EXPECT_EQ((DspLoop{"", 4, 12, 1}).interval(), 3u) << "17 instructions";
  EXPECT_EQ(kLoop.setup(), 16u) << "a branch of six cycles, and a prologue as long as an iteration";
  EXPECT_EQ(DspLoop{}.setup(), 0u);
}

// Code: 2 * 4 * 40 bytes = 10 bursts of a cold row: data from clock 4 to 44, that is cycle 88, and 4 more.
TEST(Dsp, FetchesTheCodeOfALoopOnce) {
  Dsp dsp(without_refresh());
  EXPECT_EQ(dsp.work({.loop = &kLoop}, 0), 92u + 16 + 10);
  EXPECT_EQ(dsp.counters().code, 320u);
  EXPECT_EQ(dsp.work({.loop = &kLoop}, 1000), 1010u) << "it goes on with the same loop";
  const DspCycle other = dsp.work({.loop = &kOther}, 2000);
  EXPECT_GT(other, 2000u + kOther.setup() + kOther.interval());
  EXPECT_EQ(dsp.work({.loop = &kLoop}, 3000), 3000u + 16 + 10) << "both are in the program cache";
  EXPECT_EQ(dsp.work({.loop = &kOther}, 4000), 4000u + kOther.setup() + kOther.interval());
  EXPECT_EQ(dsp.counters().loops, 4u);
  EXPECT_EQ(dsp.counters().compute, 10u + 16 + 10 + 10 + 16 + 2 * (kOther.setup() + kOther.interval()));
}

TEST(Dsp, FetchesCodeAgainThatOthersHaveDrivenOut) {
  static constexpr DspLoop kLong{"more than half of the cache", 100, 100, 100};
  static constexpr DspLoop kLonger{"and another", 100, 100, 101};
  Dsp dsp(without_refresh());
  const auto fetched = [&dsp](const DspLoop& loop, DspCycle at) {
    const std::uint64_t before = dsp.counters().code;
    dsp.work({.loop = &loop}, at);
    return dsp.counters().code > before;
  };
  EXPECT_TRUE(fetched(kLong, 0));
  EXPECT_TRUE(fetched(kLonger, 10'000));
  EXPECT_TRUE(fetched(kLong, 20'000));
  EXPECT_FALSE(fetched(kLong, 30'000));
}

constexpr std::uint64_t kData = (1 << 20) + 4096;  // in another bank than the code

// One that is in its loop, its code there.
struct Warm {
  explicit Warm(const v1::BoardConfig& config = without_refresh()) : dsp(config) { dsp.work({.loop = &kLoop}, 0); }
  // The cycles that such a task takes beyond an iteration.
  DspCycle waits(std::uint64_t address, std::uint32_t bytes, Kind kind) {
    at += 1000;
    return dsp.work(DspTask{.loop = &kLoop}.with({address, bytes, kind}), at) - at - kLoop.interval();
  }
  Dsp dsp;
  DspCycle at = 0;
};

// RCD + CL + burst are 80 ns of a memory of 100 MHz, and the controller takes 4 cycles, whatever the DSP's clock.
TEST(Dsp, HasAMemoryWithAClockOfItsOwn) {
  for (const auto& [khz, cycles] : {std::pair{100'000u, 8u}, {200'000u, 16u}, {400'000u, 32u}, {250'000u, 20u}}) {
    v1::BoardConfig config = without_refresh();
    config.mutable_dsp()->set_clock_khz(khz);
    EXPECT_EQ(Warm(config).waits(kData, 32, Kind::kRead), cycles + 4) << khz;
  }
}

TEST(Dsp, WaitsForALineThatItReadsOrChangesAndNotForOneThatItWrites) {
  Warm warm;
  // A cold bank: RCD + CL + burst = 8 clocks of two cycles, and 4 of the controller.
  EXPECT_EQ(warm.waits(kData, 32, Kind::kRead), 20u);
  EXPECT_EQ(warm.waits(kData, 32, Kind::kRead), 0u) << "it is in the cache";
  EXPECT_EQ(warm.waits(kData, 32, Kind::kWrite), 0u) << "and changed there";
  EXPECT_EQ(warm.dsp.memory().counters().packets_written, 0u);
  EXPECT_EQ(warm.waits(kData + 32, 8, Kind::kChange), 16u) << "its row is open";
  EXPECT_EQ(warm.waits(kData + 64, 16, Kind::kWrite), 0u);
  EXPECT_EQ(warm.dsp.memory().counters().packets_written, 1u) << "past the cache";
  EXPECT_EQ(warm.dsp.counters().hits, 2u);
  EXPECT_EQ(warm.dsp.counters().misses, 3u);
}

TEST(Dsp, WaitsForAWriteOnlyIfFourOthersWaitBeforeIt) {
  Warm warm;
  // Each to another row of one bank, 8 clocks from WR to WR: 4 beats with tWR, PRE and ACT. The DSP asks for one in 10
  // cycles, which are 5 clocks.
  const auto write = [&warm](std::uint64_t row, DspCycle at) {
    return warm.dsp.work(DspTask{.loop = &kLoop}.with({kData + row * 4 * 4096, 32, Kind::kWrite}), at) - at -
           kLoop.interval();
  };
  DspCycle at = 1000;
  for (std::uint64_t row = 1; row <= 4; ++row, at += 10) EXPECT_EQ(write(row, at), 0u) << row;
  for (std::uint64_t row = 5; row <= 20; ++row, at += 10) write(row, at);
  EXPECT_GT(warm.dsp.counters().waits, 92u) << "beside those for the code";
}

TEST(Dsp, WritesAChangedLineBackWhenTwoOthersHaveTakenItsSet) {
  Warm warm;
  constexpr std::uint64_t kSet = Dsp::kDataBytes / Dsp::kWays;  // addresses so far apart share a set
  warm.waits(0, 32, Kind::kChange);
  warm.waits(kSet, 32, Kind::kRead);
  EXPECT_EQ(warm.dsp.memory().counters().packets_written, 0u);
  warm.waits(2 * kSet, 32, Kind::kRead);
  EXPECT_EQ(warm.dsp.memory().counters().packets_written, 1u);
  warm.waits(3 * kSet, 32, Kind::kRead);
  EXPECT_EQ(warm.dsp.memory().counters().packets_written, 1u) << "the line that left had not changed";
}

TEST(Dsp, TakesTheLinesOfAUseOneAfterTheOther) {
  Warm warm;
  EXPECT_EQ(warm.waits(kData + 20, 24, Kind::kChange), 20u + 16) << "24 bytes over a line's end";
}

TEST(Dsp, TakesNoTimeAndNoMemoryIfItIsIdeal) {
  v1::BoardConfig config;
  config.mutable_ideal()->set_dsp(1);
  Dsp dsp(config);
  EXPECT_EQ(dsp.work(DspTask{.loop = &kLoop, .more_cycles = 100}.with({0, 32, Kind::kRead}), 50), 50u);
  EXPECT_EQ(dsp.counters().busy(), 0u);
  EXPECT_EQ(dsp.memory().counters().packets_read, 0u);
}

TEST(Dsp, SaysWhenItWaitsForItsMemory) {
  Warm warm;
  warm.waits(kData, 32, Kind::kRead);
  EXPECT_TRUE(warm.dsp.waits(warm.at));
  EXPECT_TRUE(warm.dsp.waits(warm.at + 19));
  EXPECT_FALSE(warm.dsp.waits(warm.at + 20));
}

TEST(OverflowStore, SendsTheRaysOfAQueueInTheirOrderOnceTheyHaveASlot) {
  OverflowStore store(3);
  for (const std::uint32_t ray : {10u, 11u, 12u}) store.keep(1, ray);
  store.keep(2, 20);
  EXPECT_FALSE(store.has_ready());
  store.make_ready(2);
  store.make_ready(1);
  store.keep_ready(30);
  store.make_ready(1);
  EXPECT_EQ(store.size(), 5u);
  for (const auto& [ray, has_slot] : {std::pair(20u, true), {10u, true}, {30u, false}, {11u, true}}) {
    const OverflowStore::Sent sent = store.send();
    EXPECT_EQ(sent.ray, ray);
    EXPECT_EQ(sent.has_slot, has_slot);
  }
  EXPECT_FALSE(store.has_ready());
  EXPECT_EQ(store.size(), 1u);
}

TEST(OverflowStore, GivesEveryRayAPlaceOfItsOwnAndUsesItAgain) {
  OverflowStore store(1);
  const DspTask first = store.keep_ready(1), second = store.keep_ready(2);
  EXPECT_NE(first.uses[0].address, second.uses[0].address);
  EXPECT_EQ(store.send().task.uses[0].address, first.uses[0].address);
  EXPECT_EQ(store.keep_ready(3).uses[0].address, first.uses[0].address);
}

TEST(OverflowStore, SaysWhenItIsFull) {
  OverflowStore store(1);
  for (std::uint32_t ray = 0; ray < OverflowStore::kPlaces; ++ray) store.keep_ready(ray);
  EXPECT_THROW(store.keep_ready(0), std::length_error);
}

}  // namespace
}  // namespace gicube::emu
