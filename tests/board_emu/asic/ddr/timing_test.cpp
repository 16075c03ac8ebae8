// Every row of the timing table, alone: the later command is blocked at n - 1 and ready at n.
#include "asic/ddr/channel.h"

#include "../dram/channels.h"
#include "asic/dram/wires.h"
#include "probed_device.h"

namespace gicube::emu::ddr {
namespace {

using Rank = dram::ProbedDevice<Rules>;
using enum Command;
using enum Scope;

// The default table, typed from the data sheets' numbers at 10 ns a clock and not computed.
const std::vector<Constraint> kExpected{{"tRAS", kActivate, kPrecharge, kBank, 5},
                                        {"tRC", kActivate, kActivate, kBank, 7},
                                        {"tRC", kActivate, kRefresh, kDevice, 7},
                                        {"tRCD", kActivate, kRead, kBank, 2},
                                        {"tRCD", kActivate, kWrite, kBank, 2},
                                        {"tRP", kPrecharge, kActivate, kBank, 2},
                                        {"tRP", kPrecharge, kRefresh, kDevice, 2},
                                        {"tRRD", kActivate, kActivate, kDevice, 2},
                                        {"tRFC", kRefresh, kActivate, kDevice, 8},
                                        {"tRFC", kRefresh, kRefresh, kDevice, 8},
                                        {"BL", kRead, kPrecharge, kBank, 1},
                                        {"tWR", kWrite, kPrecharge, kBank, 4},
                                        {"WL+BL+tWTR", kWrite, kRead, kDevice, 3},
                                        {"BL", kRead, kRead, kChannel, 1},
                                        {"BL", kWrite, kWrite, kChannel, 1},
                                        {"CL+BL+1-WL", kRead, kWrite, kChannel, 3},
                                        {"WL+BL-CL", kWrite, kRead, kChannel, 1},
                                        {"BL+switch", kRead, kRead, kOtherDevice, 2},
                                        {"WL+BL+switch-CL", kWrite, kRead, kOtherDevice, 1},
                                        {"CL", kRead, kData, kChannel, 2},
                                        {"WL", kWrite, kData, kChannel, 1}};

dram::ConstraintTable table(const Constraint& row) { return {Rules::kName, Rules::enforced, {row}}; }

TEST(DdrTiming, DefaultTableIsTheDataSheets) { EXPECT_EQ(dram::rank_timing<Rules>(v1::DdrConfig()).rows(), kExpected); }

TEST(DdrTiming, RefusesARowThatTheModelWouldIgnore) {
  EXPECT_THROW(table({"tX", kRead, kActivate, kBank, 3}), std::invalid_argument);
  EXPECT_THROW(table({"tX", kPrecharge, kActivate, kNeighbour, 3}), std::invalid_argument);
  EXPECT_THROW(table({"tX", kActivate, kActivate, kChannel, 3}), std::invalid_argument);
}

// Its table has no row for the writes that follow another rank's data: the controller drives both.
TEST(DdrTiming, HonoursThePairsOfItsTableAndWritesAfterAnotherRanksData) {
  dram::expect_enforced<Rules>(kExpected,
                               {{"", kRead, kWrite, kOtherDevice, 0}, {"", kWrite, kWrite, kOtherDevice, 0}});
}

TEST(DdrTiming, DataNeverOverlapWithALongerReadLatency) {
  v1::DdrConfig config;
  config.set_t_cl(3);
  const dram::ConstraintTable timing = dram::rank_timing<Rules>(config);
  EXPECT_EQ(timing.delay(kChannel, kRead, kWrite), 4u);
  EXPECT_EQ(timing.delay(kChannel, kWrite, kRead), 1u);
}

class DdrConstraint : public testing::TestWithParam<Constraint> {};

// When `row.to` may begin in a rank that knows only this row, after `row.from` began at `t`.
Tcycle ready_in_rank(const Constraint& row, Tcycle t) {
  Rank rank(table(row));
  const int from = 1, to = row.scope == kBank ? 1 : 2;
  const auto open = [&rank](int bank) {
    if (rank.open_row(bank) == kClosed) rank.issue(kActivate, {bank, 7}, 0);
  };
  // Both banks are brought to their states long before, so that only what is issued at `t` counts.
  if (row.from != kActivate && row.from != kRefresh) open(from);
  if (to != from && (row.to == kRead || row.to == kWrite)) open(to);
  rank.issue(row.from, {from, 7}, t);
  if (row.to == kRefresh && row.from == kActivate) rank.issue(kPrecharge, {from}, t + 1);
  if (row.to == kActivate && row.from == kActivate && to == from) rank.issue(kPrecharge, {from}, t + 1);
  return rank.probe(row.to, {to, 7}, t);
}

Tcycle ready_on_wires(const Constraint& row, Tcycle t) {
  dram::ColumnWires<true> wires(table(row));
  if (row.to == kData) return wires.data(row.from, t);
  wires.reserve(row.from, 3, t);
  return wires.probe(row.to, row.scope == kOtherDevice ? 2 : 3, t);
}

TEST_P(DdrConstraint, BlocksUntilItsTimeAndNoLonger) {
  constexpr Tcycle kStart = 1000;
  const Constraint& row = GetParam();
  const bool wires = row.scope == kChannel || row.scope == kOtherDevice;
  EXPECT_EQ(wires ? ready_on_wires(row, kStart) : ready_in_rank(row, kStart), kStart + row.cycles);
}

INSTANTIATE_TEST_SUITE_P(Row, DdrConstraint, testing::ValuesIn(kExpected), dram::name_of_row);

}  // namespace
}  // namespace gicube::emu::ddr
