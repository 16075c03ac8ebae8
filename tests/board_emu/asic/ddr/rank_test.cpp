#include "asic/ddr/channel.h"

#include "gicube/v1/board_config.pb.h"
#include "probed_device.h"
#include "test.h"

namespace gicube::emu::ddr {
namespace {

using Rank = dram::ProbedDevice<Rules>;
using enum Command;

const dram::ConstraintTable kTiming = dram::rank_timing<Rules>(v1::DdrConfig());

TEST(DdrRank, ActivatesOnlyAPrechargedBank) {
  Rank rank(kTiming);
  rank.issue(kActivate, {1, 7}, 0);
  EXPECT_EQ(rank.probe(kActivate, {1, 8}, 100), kNever);
  for (const int other : {0, 2, 3}) EXPECT_EQ(rank.probe(kActivate, {other, 8}, 100), 100u);
}

TEST(DdrRank, ReadsAndPrechargesOnlyAnOpenBank) {
  Rank rank(kTiming);
  for (const Command command : {kRead, kWrite, kPrecharge}) EXPECT_EQ(rank.probe(command, {3}, 0), kNever);
  rank.issue(kActivate, {3, 7}, 0);
  for (const Command command : {kRead, kWrite, kPrecharge}) EXPECT_EQ(rank.probe(command, {3}, 100), 100u);
}

TEST(DdrRank, RefreshesOnlyWhenAllItsBanksArePrecharged) {
  Rank rank(kTiming);
  rank.issue(kActivate, {0, 7}, 0);
  rank.issue(kActivate, {2, 7}, 10);
  EXPECT_EQ(rank.probe(kRefresh, {}, 100), kNever);
  rank.issue(kPrecharge, {0}, 100);
  EXPECT_EQ(rank.probe(kRefresh, {}, 100), kNever);
  rank.issue(kPrecharge, {2}, 101);
  EXPECT_EQ(rank.probe(kRefresh, {}, 100), 103u);
  rank.issue(kRefresh, {}, 103);
  EXPECT_EQ(rank.probe(kActivate, {0, 8}, 100), 111u);
  EXPECT_EQ(rank.probe(kRefresh, {}, 100), 111u);
}

TEST(DdrRank, ABankTurnsInSeven) {
  Rank rank(kTiming);
  rank.issue(kActivate, {3, 1}, 100);
  EXPECT_EQ(rank.probe(kRead, {3}, 0), 102u);
  rank.issue(kRead, {3}, 102);
  EXPECT_EQ(rank.probe(kPrecharge, {3}, 0), 105u);
  rank.issue(kPrecharge, {3}, 105);
  EXPECT_EQ(rank.probe(kActivate, {3, 2}, 0), 107u);
}

TEST(DdrRank, AWriteHoldsItsRowAndReadsOfTheRank) {
  Rank rank(kTiming);
  rank.issue(kActivate, {0, 1}, 100);
  rank.issue(kActivate, {1, 1}, 102);
  rank.issue(kWrite, {0}, 110);
  EXPECT_EQ(rank.probe(kPrecharge, {0}, 0), 114u);
  EXPECT_EQ(rank.probe(kRead, {1}, 0), 113u);
  EXPECT_EQ(rank.probe(kWrite, {1}, 0), 104u);
}

TEST(DdrRank, AsksChangeNothing) {
  Rank rank(kTiming);
  rank.issue(kActivate, {3, 1}, 100);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(rank.probe(kWrite, {3}, 0), 102u);
  EXPECT_EQ(rank.open_row(3), 1);
  EXPECT_EQ(rank.open_banks(), 1u << 3);
}

}  // namespace
}  // namespace gicube::emu::ddr
