#include "../dram/channels.h"

namespace gicube::emu::rdram {
namespace {

using dram::at;

std::vector<IssuedCommand> only(const std::vector<IssuedCommand>& trace, Command command) {
  std::vector<IssuedCommand> commands;
  for (const IssuedCommand& c : trace) {
    if (c.command == command) commands.push_back(c);
  }
  return commands;
}

TEST(RdramRefresh, ComesToEveryBankInTurnAndClosesItsRow) {
  for (const unsigned devices : {1u, 2u}) {
    std::vector<IssuedCommand> trace;
    Channel channel(v1::RdramConfig(), devices);
    channel.set_trace(&trace);
    channel.advance(781 * 70);
    const auto refreshes = only(trace, Command::kRefresh), precharges = only(trace, Command::kPrecharge);
    ASSERT_EQ(refreshes.size(), 70u * devices);
    for (std::size_t i = 0; i < refreshes.size(); ++i) EXPECT_EQ(refreshes[i].bank, i / devices % 32);
    ASSERT_EQ(precharges.size(), refreshes.size() - 1);
    for (std::size_t i = 0; i < precharges.size(); ++i) EXPECT_EQ(precharges[i].begin, refreshes[i].begin + 20);
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

}  // namespace
}  // namespace gicube::emu::rdram
