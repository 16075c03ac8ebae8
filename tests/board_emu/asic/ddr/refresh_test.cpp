#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "asic/ddr/channel.h"
#include "ddr_traffic.h"
#include "long_times.h"

namespace gicube::emu::ddr {
namespace {

using test_traffic::at;
using test_traffic::without_refresh;

TEST(DdrRefresh, ComesEveryInterval) {
  std::vector<IssuedCommand> trace;
  Channel channel(v1::DdrConfig(), 1);
  channel.set_trace(&trace);
  channel.advance(1562 * 70);
  ASSERT_EQ(trace.size(), 70u);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    EXPECT_EQ(trace[i].command, Command::kRefresh);
    EXPECT_EQ(trace[i].begin, 1562 * (i + 1));
  }
  EXPECT_EQ(channel.counters().refreshes, 70u);
}

TEST(DdrRefresh, GivesEachRankItsOwnEveryInterval) {
  std::vector<IssuedCommand> trace;
  Channel channel(v1::DdrConfig(), 2);
  channel.set_trace(&trace);
  channel.advance(1562 * 40);
  ASSERT_EQ(trace.size(), 80u);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    EXPECT_EQ(trace[i].device, i % 2);
    EXPECT_EQ(trace[i].begin, 1562 * (i + 1) / 2);
  }
}

TEST(DdrRefresh, PrechargesEveryOpenBankOfItsRank) {
  std::vector<IssuedCommand> trace;
  Channel channel(v1::DdrConfig(), 1);
  channel.read(at(1, 7), 0);
  channel.read(at(3, 8), 0);
  channel.set_trace(&trace);
  channel.advance(1562);
  ASSERT_EQ(trace.size(), 3u);
  EXPECT_EQ(trace[0].command, Command::kPrecharge);
  EXPECT_EQ(trace[0].begin, 1562u);
  EXPECT_EQ(trace[1].begin, 1563u);
  EXPECT_EQ(trace[2].command, Command::kRefresh);
  EXPECT_EQ(trace[2].begin, 1563u + 2);
}

TEST(DdrRefresh, DelaysAReadOfItsRankByItsTime) {
  Channel channel(v1::DdrConfig(), 1);
  const Access access = channel.read(at(2, 7), 1562);
  EXPECT_EQ(access.data_begin, 1562u + 8 + 2 + 2);
  EXPECT_EQ(access.cause, Delay::kRefresh);
}

TEST(DdrRefresh, ClosesRowsThatWereOpen) {
  Channel channel(v1::DdrConfig(), 1);
  channel.read(at(2, 7), 0);
  // PRE 1562, REF 1564, ACT 1572, RD 1574.
  EXPECT_EQ(channel.read(at(2, 7), 1562).data_begin, 1576u);
}

TEST(DdrRefresh, LeavesAnotherRankAlone) {
  Channel channel(v1::DdrConfig(), 2);
  channel.read(at(2, 7, 0, 1), 0);
  const Access access = channel.read(at(2, 7, 0, 1), 781);  // when rank 0 is refreshed
  EXPECT_EQ(access.data_begin, 781u + 1 + 2) << "REF takes the command bus in that clock";
  EXPECT_EQ(access.cause, Delay::kTransfer);
}

TEST(DdrRefresh, CanBeSwitchedOff) {
  Channel channel(without_refresh(), 1);
  channel.advance(1'000'000);
  EXPECT_EQ(channel.counters().refreshes, 0u);
}

TEST(DdrRefresh, OfALongTimeAtOnceIsThatOfItsParts) {
  for (const unsigned devices : {1u, 2u, 4u}) {
    for (const unsigned interval : {64u, 100u, 1562u, 5000u}) {
      if (interval < 64 * devices) continue;  // none are left out
      v1::DdrConfig config;
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
}  // namespace gicube::emu::ddr
