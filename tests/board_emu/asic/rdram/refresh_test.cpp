#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>

#include "asic/rdram/channel.h"
#include "long_times.h"
#include "rdram_traffic.h"

namespace gicube::emu::rdram {
namespace {

using test_traffic::at;
using test_traffic::without_refresh;

std::vector<IssuedCommand> only(const std::vector<IssuedCommand>& trace, Command command) {
  std::vector<IssuedCommand> commands;
  for (const IssuedCommand& c : trace) {
    if (c.command == command) commands.push_back(c);
  }
  return commands;
}

TEST(RdramRefresh, ComesEveryIntervalToEveryBankInTurn) {
  std::vector<IssuedCommand> trace;
  Channel channel(v1::RdramConfig(), 1);
  channel.set_trace(&trace);
  channel.advance(781 * 70);
  const auto refreshes = only(trace, Command::kRefresh), precharges = only(trace, Command::kPrecharge);
  ASSERT_EQ(refreshes.size(), 70u);
  for (std::size_t i = 0; i < refreshes.size(); ++i) {
    EXPECT_EQ(refreshes[i].begin, 781 * (i + 1));
    EXPECT_EQ(refreshes[i].bank, i % 32);
  }
  ASSERT_EQ(precharges.size(), 69u);
  for (std::size_t i = 0; i < precharges.size(); ++i) EXPECT_EQ(precharges[i].begin, 781 * (i + 1) + 20);
  EXPECT_EQ(channel.counters().refreshes, 70u);
}

TEST(RdramRefresh, GivesEachDeviceItsOwnEveryInterval) {
  std::vector<IssuedCommand> trace;
  Channel channel(v1::RdramConfig(), 2);
  channel.set_trace(&trace);
  channel.advance(781 * 40);
  const auto refreshes = only(trace, Command::kRefresh);
  ASSERT_EQ(refreshes.size(), 80u);
  for (std::size_t i = 0; i < refreshes.size(); ++i) {
    EXPECT_EQ(refreshes[i].device, i % 2);
    EXPECT_EQ(refreshes[i].bank, i / 2 % 32);
    EXPECT_EQ(refreshes[i].begin, 781 * (i + 1) / 2);
  }
}

TEST(RdramRefresh, ClosesWhatStandsInItsWay) {
  std::vector<IssuedCommand> trace;
  Channel channel(v1::RdramConfig(), 1);
  channel.read(at(1, 7), 0);  // a neighbour of bank 0
  channel.set_trace(&trace);
  channel.advance(781);
  ASSERT_EQ(trace.size(), 2u);
  EXPECT_EQ(trace[0].command, Command::kPrecharge);
  EXPECT_EQ(trace[0].begin, 781u);
  EXPECT_EQ(trace[1].command, Command::kRefresh);
  EXPECT_EQ(trace[1].begin, 781u + 8);
}

TEST(RdramRefresh, DelaysAReadOfItsBankByATurn) {
  Channel channel(v1::RdramConfig(), 1);
  const Access access = channel.read(at(0, 7), 781);
  // REFA 781, PRE 801, ACT 809, RD 816.
  EXPECT_EQ(access.data_begin, 781u + 28 + 7 + 12);
  EXPECT_EQ(access.cause, Delay::kRefresh);
}

TEST(RdramRefresh, DelaysAnActivationElsewhereByTheDevicesGap) {
  Channel channel(v1::RdramConfig(), 1);
  const Access access = channel.read(at(9, 7), 781);
  EXPECT_EQ(access.data_begin, 781u + 8 + 7 + 12);
  EXPECT_EQ(access.cause, Delay::kRefresh);
}

// REFA at 781 holds up activations for 8; then a bank's own precharge does.
TEST(RdramRefresh, IsTheCauseOfADelayForTheDevicesGapOnly) {
  for (const auto& [arrival, cause] : {std::pair{788u, Delay::kRefresh}, {789u, Delay::kBank}}) {
    Channel channel(v1::RdramConfig(), 1);
    channel.read(at(9, 7), 0);
    const Access access = channel.read(at(9, 8), arrival);
    EXPECT_EQ(access.data_begin, arrival + 8 + 7 + 12);
    EXPECT_EQ(access.cause, cause) << arrival;
  }
}

// PRE of the refreshed bank at 801; its wires are free from 805 on.
TEST(RdramRefresh, AnActivationWithoutAPrechargeNeedsNoGap) {
  Channel channel(v1::RdramConfig(), 1);
  const Access access = channel.read(at(9, 7), 806);
  EXPECT_EQ(access.data_begin, 806u + 7 + 12);
  EXPECT_EQ(access.cause, Delay::kTransfer);
}

TEST(RdramRefresh, LeavesAnOpenRowElsewhereAlone) {
  Channel channel(v1::RdramConfig(), 1);
  channel.read(at(9, 7), 0);
  const Access access = channel.read(at(9, 7), 781);
  EXPECT_EQ(access.data_begin, 781u + 12);
  EXPECT_EQ(access.cause, Delay::kTransfer);
}

TEST(RdramRefresh, CanBeSwitchedOff) {
  Channel channel(without_refresh(), 1);
  channel.advance(1'000'000);
  EXPECT_EQ(channel.counters().refreshes, 0u);
}

TEST(RdramRefresh, OfALongTimeAtOnceIsThatOfItsParts) {
  for (const unsigned devices : {1u, 2u, 5u}) {
    for (const unsigned interval : {64u, 100u, 781u, 5000u}) {
      if (interval < 64 * devices) continue;  // none are left out
      v1::RdramConfig config;
      config.set_refresh_interval(interval);
      expect_long_times_to_be_short_ones([&] { return std::make_unique<Channel>(config, devices); }, devices, interval,
                                         [&](std::mt19937& random) {
                                           const auto below = [&](unsigned limit) {
                                             return static_cast<unsigned>(random() % limit);
                                           };
                                           return at(below(32), below(3), below(64), below(devices));
                                         });
    }
  }
}

}  // namespace
}  // namespace gicube::emu::rdram
