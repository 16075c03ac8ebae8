// The controller against hand-worked cases and the calibration vectors of the data books.
#include "asic/rdram/channel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "rdram_traffic.h"

namespace gicube::emu::rdram {
namespace {

using test_traffic::at;
using test_traffic::without_refresh;

TEST(RdramChannel, ColdReadTakesRcdPlusPacketPlusCac) {
  Channel channel(without_refresh(), 1);
  const Access access = channel.read(at(3, 9), 1000);
  // ACT 1000, RD 1007..1010, data 8 after its end.
  EXPECT_EQ(access.data_begin, 1000u + 7 + 4 + 8);
  EXPECT_EQ(access.data_end, 1023u);
  EXPECT_EQ(access.cause, Delay::kTransfer);
}

TEST(RdramChannel, ColdWriteTakesRcdPlusPacketPlusCwd) {
  Channel channel(without_refresh(), 1);
  EXPECT_EQ(channel.write(at(3, 9), 1000).data_begin, 1000u + 7 + 4 + 6);
}

TEST(RdramChannel, OpenRowTakesPacketPlusCac) {
  Channel channel(without_refresh(), 1);
  channel.read(at(3, 9), 0);
  EXPECT_EQ(channel.read(at(3, 9, 1), 1000).data_begin, 1012u);
  EXPECT_EQ(channel.counters().row_hits, 1u);
}

TEST(RdramChannel, OtherRowOfAnOpenBankTakesAPrechargeMore) {
  Channel channel(without_refresh(), 1);
  channel.read(at(3, 9), 0);
  const Access access = channel.read(at(3, 10), 1000);
  EXPECT_EQ(access.data_begin, 1000u + 8 + 7 + 12);
  EXPECT_EQ(access.cause, Delay::kBank);
  EXPECT_EQ(channel.counters().conflicts, 1u);
}

TEST(RdramChannel, BothOpenNeighboursArePrechargedFirst) {
  Channel channel(without_refresh(), 1);
  channel.read(at(3, 9), 0);
  channel.read(at(5, 9), 0);
  // PRE 1000 and 1008 (tPP), ACT 1016, RD 1023.
  EXPECT_EQ(channel.read(at(4, 9), 1000).data_begin, 1000u + 16 + 7 + 12);
  EXPECT_EQ(channel.counters().precharges, 2u);
}

TEST(RdramChannel, QueuedPacketsOfOpenRowsFollowOneAnother) {
  Channel channel(without_refresh(), 1);
  const Tcycle first = channel.read(at(3, 9), 0).data_begin;
  const Access second = channel.read(at(3, 9, 1), 0);
  EXPECT_EQ(second.data_begin, first + 4);
  EXPECT_EQ(second.cause, Delay::kTransfer);
}

TEST(RdramChannel, ActivationsOfOneDeviceAreEightApartAndOfTwoDevicesFour) {
  Channel one(without_refresh(), 1);
  const Tcycle first = one.read(at(3, 9), 0).data_begin;
  const Access second = one.read(at(7, 9), 0);
  EXPECT_EQ(second.data_begin, first + 8);
  EXPECT_EQ(second.cause, Delay::kBank);
  Channel two(without_refresh(), 2);
  two.read(at(3, 9), 0);
  EXPECT_EQ(two.read(at(7, 9, 0, 1), 0).data_begin, first + 4);
}

TEST(RdramChannel, CallingOrderIsServiceOrder) {
  Channel channel(without_refresh(), 1);
  channel.read(at(3, 9), 0);
  const Access slow = channel.read(at(3, 10), 0);
  EXPECT_EQ(channel.read(at(3, 10, 1), 0).data_begin, slow.data_end);
  EXPECT_GT(channel.read(at(9, 1), 0).data_begin, slow.data_end);
}

TEST(RdramChannel, SameCallsGiveTheSameTimesWithOrWithoutATrace) {
  std::vector<IssuedCommand> trace;
  Channel a(v1::RdramConfig(), 2), b(v1::RdramConfig(), 2);
  b.set_trace(&trace);
  const auto first = test_traffic::random_traffic(a, 2, 5000, 1), second = test_traffic::random_traffic(b, 2, 5000, 1);
  EXPECT_EQ(first, second);
  EXPECT_EQ(a.counters(), b.counters());
  const ChannelCounters counters = a.counters();
  EXPECT_EQ(trace.size(), counters.packets_read + counters.packets_written + counters.activates + counters.precharges +
                              counters.refreshes);
}

TEST(RdramChannel, CountsWhatItDid) {
  Channel channel(without_refresh(), 1);
  channel.read(at(2, 1), 0);      // miss
  channel.read(at(2, 1, 5), 0);   // hit
  channel.write(at(2, 2), 0);     // conflict
  channel.write(at(8, 2), 1000);  // miss
  const ChannelCounters expected{2, 2, 1, 3, 1, 3, 1, 0, 16, 0};
  EXPECT_EQ(channel.counters(), expected);
}

TEST(RdramChannel, CountsThePacketsOfEachBankOfEachDevice) {
  Channel channel(without_refresh(), 2);
  channel.read(at(2, 1), 0);
  channel.write(at(2, 2), 0);
  channel.read(at(31, 1), 1000);
  Location other = at(2, 1);
  other.device = 1;
  channel.write(other, 2000);
  std::vector<std::uint64_t> expected(2 * 32);
  expected[2] = 2;
  expected[31] = 1;
  expected[32 + 2] = 1;
  EXPECT_EQ(channel.bank_packets(), expected);
}

TEST(RdramChannel, RefusesToBeEmpty) { EXPECT_THROW(Channel(v1::RdramConfig(), 0), std::invalid_argument); }

TEST(RdramChannel, DescribesItself) {
  Channel channel(v1::RdramConfig(), 1);
  std::ostringstream text;
  channel.dump(text);
  EXPECT_NE(text.str().find("next refresh due at tCYCLE 781"), std::string::npos) << text.str();
}

// Calibration vectors: the share of DQ over whole periods in the steady state, all packets asked for at once.

double use(const std::vector<Access>& accesses, std::size_t skip) {
  const Tcycle begin = accesses[skip].data_begin, end = accesses.back().data_begin;
  return 4.0 * static_cast<double>(accesses.size() - 1 - skip) / static_cast<double>(end - begin);
}

TEST(RdramCalibration, InterleavedPairsOnNonAdjacentBanksUseAllOfDq) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 4000; ++i) {
    for (const unsigned column : {0u, 1u}) accesses.push_back(channel.read(at(2 * i % 32, i / 16 % 512, column), 0));
  }
  EXPECT_DOUBLE_EQ(use(accesses, 100), 1.0);
  EXPECT_EQ(channel.counters().row_misses, 4000u);
}

// Read, read, write, write, each two dualocts of a row of its own.
std::vector<Access> read_read_write_write(Channel& channel, bool one_device) {
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 4000; ++i) {
    for (const unsigned column : {0u, 1u}) {
      const Location place = at(2 * i % 32, i / 16 % 512, column, one_device ? 0 : i % 4);
      accesses.push_back(i % 4 < 2 ? channel.read(place, 0) : channel.write(place, 0));
    }
  }
  accesses.push_back(channel.read(at(0, 250, 0), 0));  // closes the last period
  return accesses;
}

TEST(RdramCalibration, ReadReadWriteWriteTakes42OnOneDevice) {
  Channel channel(without_refresh(), 1);
  EXPECT_DOUBLE_EQ(use(read_read_write_write(channel, true), 800), 32.0 / 42);
  EXPECT_EQ(channel.counters().turnaround, 1000u * 10);
}

TEST(RdramCalibration, ReadReadWriteWriteTakes34OnSeveralDevices) {
  Channel channel(without_refresh(), 4);
  EXPECT_DOUBLE_EQ(use(read_read_write_write(channel, false), 800), 32.0 / 34);
}

TEST(RdramCalibration, SingleDualoctsOfNewRowsUseHalfOfDqAtMost) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 4000; ++i) accesses.push_back(channel.read(at(2 * i % 32, i / 16 % 512), 0));
  EXPECT_DOUBLE_EQ(use(accesses, 100), 0.5);
}

TEST(RdramCalibration, OneBankAgainAndAgainUsesASeventh) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 1000; ++i) accesses.push_back(channel.read(at(6, i % 512), 0));
  EXPECT_DOUBLE_EQ(use(accesses, 10), 4.0 / 28);
}

}  // namespace
}  // namespace gicube::emu::rdram
