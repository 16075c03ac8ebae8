#include "../dram/channels.h"

namespace gicube::emu::ddr {
namespace {

using dram::at;

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

}  // namespace
}  // namespace gicube::emu::ddr
