// The controller against hand-worked cases.
#include "asic/ddr/channel.h"

#include "../dram/channels.h"

namespace gicube::emu::ddr {
namespace {

using dram::at;

v1::DdrConfig without_refresh() { return dram::without_refresh<dram::Ddr>(); }

TEST(DdrChannel, BanksBesideEachOtherAreOpenTogether) {
  Channel channel(without_refresh(), 1);
  for (const unsigned bank : {0u, 1u, 2u, 3u}) channel.read(at(bank, 9), 0);
  for (const unsigned bank : {0u, 1u, 2u, 3u}) channel.read(at(bank, 9, 1), 100);
  EXPECT_EQ(channel.counters().conflicts, 0u);
  EXPECT_EQ(channel.counters().row_hits, 4u);
}

// ACT 0 and 2 (tRRD), RD 2 gives way to the ACT that is already asked for in no case: it is placed first. RD at 2, ACT
// 3.
TEST(DdrChannel, OneCommandBusCarriesOneCommandAClock) {
  Channel channel(without_refresh(), 1);
  EXPECT_EQ(channel.read(at(0, 9), 0).data_begin, 4u);
  EXPECT_EQ(channel.read(at(1, 9), 0).data_begin, 3u + 2 + 2);
}

TEST(DdrChannel, DataOfTwoRanksKeepAClockApart) {
  Channel channel(without_refresh(), 2);
  channel.read(at(0, 9), 0);
  channel.read(at(0, 9, 0, 1), 0);
  const Tcycle first = channel.read(at(0, 9, 1), 100).data_begin;
  EXPECT_EQ(channel.read(at(0, 9, 1, 1), 100).data_begin, first + 2);
}

TEST(DdrChannel, TurnsTheDataWiresRound) {
  Channel channel(without_refresh(), 1);
  channel.read(at(0, 9), 0);
  const Tcycle read = channel.read(at(0, 9, 1), 100).data_begin;
  EXPECT_EQ(channel.write(at(0, 9, 2), 100).data_begin, read + 2) << "a clock between for the strobes";
  // WR 103, its data 104; RD from 106 on.
  EXPECT_EQ(channel.read(at(0, 9, 3), 100).data_begin, 108u);
  EXPECT_EQ(channel.counters().turnaround, 1u + 3);
}

TEST(DdrChannel, DescribesItself) {
  Channel channel(v1::DdrConfig(), 1);
  std::ostringstream text;
  channel.dump(text);
  EXPECT_NE(text.str().find("next refresh due at clock 1562"), std::string::npos) << text.str();
}

// Calibration: the share of the data wires over whole periods in the steady state, all packets asked for at once.

// `run` packets of a row, then the next bank's.
double use_of_runs(unsigned run) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 4000; ++i) {
    for (unsigned column = 0; column < run; ++column) accesses.push_back(channel.read(at(i % 4, i / 4, column), 0));
  }
  return dram::use_of_data_wires<dram::Ddr>(accesses, 100 * run);
}

TEST(DdrCalibration, OpenRowsUseAllOfTheDataWires) { EXPECT_GT(use_of_runs(512), 0.99); }

// A row change costs a PRE and an ACT beside its RDs on the one command bus.
TEST(DdrCalibration, ShortRunsAreHeldUpByTheCommandBus) {
  EXPECT_NEAR(use_of_runs(4), 4.0 / 6, 0.01);
  EXPECT_NEAR(use_of_runs(1), 1.0 / 3, 0.01);
}

TEST(DdrCalibration, OneBankAgainAndAgainUsesASeventh) {
  Channel channel(without_refresh(), 1);
  std::vector<Access> accesses;
  for (unsigned i = 0; i < 1000; ++i) accesses.push_back(channel.read(at(2, i), 0));
  EXPECT_DOUBLE_EQ(dram::use_of_data_wires<dram::Ddr>(accesses, 10), 1.0 / 7);
}

}  // namespace
}  // namespace gicube::emu::ddr
