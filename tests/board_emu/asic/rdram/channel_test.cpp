// The controller against hand-worked cases and the calibration vectors of the data books.
#include "asic/rdram/channel.h"

#include "../dram/channels.h"

namespace gicube::emu::rdram {
namespace {

using dram::at;

v1::RdramConfig without_refresh() { return dram::without_refresh<dram::Rdram>(); }

TEST(RdramChannel, BothOpenNeighboursArePrechargedFirst) {
  Channel channel(without_refresh(), 1);
  channel.read(at(3, 9), 0);
  channel.read(at(5, 9), 0);
  // PRE 1000 and 1008 (tPP), ACT 1016, RD 1023.
  EXPECT_EQ(channel.read(at(4, 9), 1000).data_begin, 1000u + 16 + 7 + 12);
  EXPECT_EQ(channel.counters().precharges, 2u);
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

TEST(RdramChannel, DescribesItself) {
  Channel channel(v1::RdramConfig(), 1);
  std::ostringstream text;
  channel.dump(text);
  EXPECT_NE(text.str().find("next refresh due at tCYCLE 781"), std::string::npos) << text.str();
}

// Calibration vectors: the share of DQ over whole periods in the steady state, all packets asked for at once.

TEST(RdramCalibration, InterleavedPairsOnNonAdjacentBanksUseAllOfDq) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 4000; ++i) {
    for (const unsigned column : {0u, 1u}) accesses.push_back(channel.read(at(2 * i % 32, i / 16 % 512, column), 0));
  }
  EXPECT_DOUBLE_EQ(dram::use_of_data_wires<dram::Rdram>(accesses, 100), 1.0);
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
  EXPECT_DOUBLE_EQ(dram::use_of_data_wires<dram::Rdram>(read_read_write_write(channel, true), 800), 32.0 / 42);
  EXPECT_EQ(channel.counters().turnaround, 1000u * 10);
}

TEST(RdramCalibration, ReadReadWriteWriteTakes34OnSeveralDevices) {
  Channel channel(without_refresh(), 4);
  EXPECT_DOUBLE_EQ(dram::use_of_data_wires<dram::Rdram>(read_read_write_write(channel, false), 800), 32.0 / 34);
}

TEST(RdramCalibration, SingleDualoctsOfNewRowsUseHalfOfDqAtMost) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 4000; ++i) accesses.push_back(channel.read(at(2 * i % 32, i / 16 % 512), 0));
  EXPECT_DOUBLE_EQ(dram::use_of_data_wires<dram::Rdram>(accesses, 100), 0.5);
}

TEST(RdramCalibration, OneBankAgainAndAgainUsesASeventh) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 1000; ++i) accesses.push_back(channel.read(at(6, i % 512), 0));
  EXPECT_DOUBLE_EQ(dram::use_of_data_wires<dram::Rdram>(accesses, 10), 4.0 / 28);
}

}  // namespace
}  // namespace gicube::emu::rdram
