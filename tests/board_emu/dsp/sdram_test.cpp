// The DSP's memory against hand-worked cases, and its traces against the independent checker.
#include "dsp/sdram.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "long_times.h"
#include "rank_checker.h"
#include "sdram_traffic.h"

namespace gicube::emu::sdram {
namespace {

using reference::check_rank_trace;
using reference::RankRules;
using test_traffic::at;
using test_traffic::without_refresh;
using testing::IsEmpty;
using Trace = std::vector<IssuedCommand>;

TEST(Sdram, ColdReadTakesRcdPlusCasLatencyAndABurstFourClocks) {
  Channel channel(without_refresh(), 1);
  const Access access = channel.read(at(3, 9), 1000);
  EXPECT_EQ(access.data_begin, 1000u + 2 + 2);
  EXPECT_EQ(access.data_end, 1008u);
}

TEST(Sdram, ColdWriteTakesRcdAndItsDataComeWithIt) {
  Channel channel(without_refresh(), 1);
  EXPECT_EQ(channel.write(at(3, 9), 1000).data_begin, 1002u);
}

TEST(Sdram, OpenRowTakesCasLatency) {
  Channel channel(without_refresh(), 1);
  channel.read(at(3, 9), 0);
  EXPECT_EQ(channel.read(at(3, 9, 1), 1000).data_begin, 1002u);
  EXPECT_EQ(channel.counters().row_hits, 1u);
}

TEST(Sdram, OtherRowOfAnOpenBankTakesAPrechargeMore) {
  Channel channel(without_refresh(), 1);
  channel.read(at(3, 9), 0);
  const Access access = channel.read(at(3, 10), 1000);
  EXPECT_EQ(access.data_begin, 1000u + 2 + 2 + 2);
  EXPECT_EQ(access.cause, dram::Delay::kBank);
}

// RD 0's ACT 0; RD 2, 6, 10: bursts of four clocks without a gap.
TEST(Sdram, BurstsOfAnOpenRowFollowOneAnother) {
  Channel channel(without_refresh(), 1);
  EXPECT_EQ(channel.read(at(0, 9), 0).data_begin, 4u);
  EXPECT_EQ(channel.read(at(0, 9, 1), 0).data_begin, 8u);
  EXPECT_EQ(channel.read(at(0, 9, 2), 0).data_begin, 12u);
}

// The command bus is free while a burst's data are on their way: ACT of bank 1 at 2 (tRRD), behind its RD at 6.
TEST(Sdram, OpensOneBankUnderTheDataOfAnother) {
  Channel channel(without_refresh(), 1);
  EXPECT_EQ(channel.read(at(0, 9), 0).data_begin, 4u);
  EXPECT_EQ(channel.read(at(1, 9), 0).data_begin, 8u);
}

// RD 102, data 104..107, WR 109 after a clock for the wires; RD 113 after its four beats, data 115.
TEST(Sdram, TurnsTheDataWiresRound) {
  Channel channel(without_refresh(), 1);
  channel.read(at(0, 9), 0);
  EXPECT_EQ(channel.read(at(0, 9, 1), 102).data_begin, 104u);
  EXPECT_EQ(channel.write(at(0, 9, 2), 102).data_begin, 109u);
  EXPECT_EQ(channel.read(at(0, 9, 3), 102).data_begin, 115u);
}

// WR 2, its last beat 5; PRE 6 by tWR, but 5 by tRAS; ACT 8, RD 10.
TEST(Sdram, AWriteHoldsItsRow) {
  Channel channel(without_refresh(), 1);
  channel.write(at(0, 9), 0);
  EXPECT_EQ(channel.read(at(0, 10), 0).data_begin, 12u);
}

TEST(Sdram, DataOfTwoRanksKeepAClockApart) {
  Channel channel(without_refresh(), 2);
  channel.read(at(0, 9), 0);
  channel.read(at(0, 9, 0, 1), 0);
  const Tcycle first = channel.read(at(0, 9, 1), 100).data_begin;
  EXPECT_EQ(channel.read(at(0, 9, 1, 1), 100).data_begin, first + 5);
}

// PRE 1562, REF 1564, ACT 1571, RD 1573.
TEST(Sdram, RefreshesARankEachIntervalWithItsRowsClosed) {
  Channel channel(v1::SdramConfig(), 1);
  channel.read(at(2, 7), 0);
  const Access access = channel.read(at(2, 7), 1562);
  EXPECT_EQ(access.data_begin, 1575u);
  EXPECT_EQ(access.cause, dram::Delay::kRefresh);
  channel.advance(1562 * 5);
  EXPECT_EQ(channel.counters().refreshes, 5u);
}

TEST(Sdram, SameBankAgainAndAgainTakesItsRowCycle) {
  Channel channel(without_refresh(), 1);
  Tcycle last = 0;
  for (unsigned row = 0; row < 50; ++row) {
    const Tcycle begin = channel.read(at(2, row), 0).data_begin;
    // tRCD + BL + tRP = 8 clocks are longer than tRC = 7.
    EXPECT_EQ(begin, row == 0 ? 4 : last + 8);
    last = begin;
  }
}

TEST(Sdram, GivesEveryBurstAPlaceAndASequenceOfPagesDifferentBanks) {
  EXPECT_EQ(locate(0), at(0, 0, 0));
  EXPECT_EQ(locate(31), at(0, 0, 0));
  EXPECT_EQ(locate(32), at(0, 0, 1));
  EXPECT_EQ(locate(4096), at(1, 0, 0));
  EXPECT_EQ(locate(4 * 4096), at(0, 1, 0));
  EXPECT_EQ(locate(sdram_map::kRankBytes), at(0, 0, 0, 1));
  EXPECT_EQ(locate(sdram_map::kRankBytes - 1), at(3, 4095, 127));
}

class SdramTrace : public testing::TestWithParam<unsigned> {};  // ranks

// wr: from the clock after the last beat, where the board's tWR counts from the beat.
constexpr RankRules kRules{.rrd = 20, .wr = 0, .rfc = 70, .wl = 0, .wtr = 0, .burst = 4, .refresh_interval = 1562};

TEST_P(SdramTrace, OfRandomTrafficBreaksNoRuleAndIsTight) {
  for (unsigned seed = 1; seed <= 70; ++seed) {
    Trace trace;
    Channel channel(v1::SdramConfig(), GetParam());
    channel.set_trace(&trace);
    const std::vector<Tcycle> begins = test_traffic::random_traffic(channel, GetParam(), 2'000, seed);
    RankRules rules = kRules;
    rules.ranks = GetParam();
    const auto verdict = check_rank_trace(rules, trace);
    ASSERT_THAT(verdict.faults, IsEmpty()) << seed;
    EXPECT_EQ(verdict.data_begins, begins) << "data do not come when the controller said";
    EXPECT_GT(verdict.tight_commands, trace.size() * 9 / 10);
    EXPECT_GT(channel.counters().refreshes, 5u);
  }
}

INSTANTIATE_TEST_SUITE_P(Ranks, SdramTrace, testing::Values(1u, 2u, 8u));

TEST(SdramTraceOfOtherTimings, FollowsTheConfiguration) {
  v1::SdramConfig config;
  config.set_t_ras(8), config.set_t_rc(13), config.set_t_rp(3), config.set_t_rrd(4), config.set_t_rcd(5);
  config.set_t_cl(3), config.set_t_wr(5), config.set_t_rfc(20), config.set_refresh_interval(500);
  const RankRules rules{.ras = 80,
                        .rc = 130,
                        .rp = 30,
                        .rrd = 40,
                        .rcd = 50,
                        .wr = 40,
                        .rfc = 200,
                        .cl = 3,
                        .wl = 0,
                        .wtr = 0,
                        .burst = 4,
                        .refresh_interval = 500,
                        .ranks = 2};
  Trace trace;
  Channel channel(config, 2);
  channel.set_trace(&trace);
  const std::vector<Tcycle> begins = test_traffic::random_traffic(channel, 2, 20'000, 9);
  const auto verdict = check_rank_trace(rules, trace);
  EXPECT_THAT(verdict.faults, IsEmpty());
  EXPECT_EQ(verdict.data_begins, begins);
}

TEST(SdramRefresh, OfALongTimeAtOnceIsThatOfItsParts) {
  for (const unsigned devices : {1u, 2u, 8u}) {
    for (const unsigned interval : {64u, 100u, 1562u, 5000u}) {
      if (interval < 64 * devices) continue;  // none are left out
      v1::SdramConfig config;
      config.set_refresh_interval(interval);
      expect_long_times_to_be_short_ones([&] { return std::make_unique<Channel>(config, devices); }, devices, interval,
                                         [&](std::mt19937& random) {
                                           const auto below = [&](unsigned limit) {
                                             return static_cast<unsigned>(random() % limit);
                                           };
                                           return at(below(4), below(3), below(64), below(devices));
                                         });
    }
  }
}

}  // namespace
}  // namespace gicube::emu::sdram
