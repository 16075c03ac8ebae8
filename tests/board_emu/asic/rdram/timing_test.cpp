// Every row of the timing table, alone: the later command is blocked at n - 1 and ready at n.
#include "asic/rdram/channel.h"

#include "../dram/channels.h"
#include "asic/dram/wires.h"
#include "probed_device.h"

namespace gicube::emu::rdram {
namespace {

using Device = dram::ProbedDevice<Rules>;
using enum Command;
using enum Scope;

// The default table, typed from the data books' numbers and not computed.
const std::vector<Constraint> kExpected{
    {"tRAS", kActivate, kPrecharge, kBank, 20},    {"tRP", kPrecharge, kActivate, kBank, 8},
    {"tRP", kPrecharge, kActivate, kNeighbour, 8}, {"tRC", kActivate, kActivate, kBank, 28},
    {"tRR", kActivate, kActivate, kDevice, 8},     {"tRC", kActivate, kRefresh, kBank, 28},
    {"tRR", kActivate, kRefresh, kDevice, 8},      {"tRAS", kRefresh, kPrecharge, kBank, 20},
    {"tRP", kPrecharge, kRefresh, kBank, 8},       {"tRP", kPrecharge, kRefresh, kNeighbour, 8},
    {"tRC", kRefresh, kActivate, kBank, 28},       {"tRR", kRefresh, kActivate, kDevice, 8},
    {"tRC", kRefresh, kRefresh, kBank, 28},        {"tRR", kRefresh, kRefresh, kDevice, 8},
    {"tPP", kPrecharge, kPrecharge, kDevice, 8},   {"tPACK", kActivate, kActivate, kChannel, 4},
    {"tPACK", kActivate, kPrecharge, kChannel, 4}, {"tPACK", kActivate, kRefresh, kChannel, 4},
    {"tPACK", kPrecharge, kActivate, kChannel, 4}, {"tPACK", kPrecharge, kPrecharge, kChannel, 4},
    {"tPACK", kPrecharge, kRefresh, kChannel, 4},  {"tPACK", kRefresh, kActivate, kChannel, 4},
    {"tPACK", kRefresh, kPrecharge, kChannel, 4},  {"tPACK", kRefresh, kRefresh, kChannel, 4},
    {"tRCD", kActivate, kRead, kBank, 7},          {"tRCD", kActivate, kWrite, kBank, 7},
    {"tOFFP", kRead, kPrecharge, kBank, 4},        {"tRTR+tOFFP", kWrite, kPrecharge, kBank, 12},
    {"tRTR+tPACK", kWrite, kRead, kDevice, 12},    {"tPACK", kRead, kRead, kChannel, 4},
    {"tPACK", kWrite, kWrite, kChannel, 4},        {"tPACK+tCAC-tCWD", kRead, kWrite, kChannel, 6},
    {"tPACK", kWrite, kRead, kChannel, 4},         {"tPACK+tCAC", kRead, kData, kChannel, 12},
    {"tPACK+tCWD", kWrite, kData, kChannel, 10},
};

dram::ConstraintTable table(const Constraint& row) { return {Rules::kName, Rules::enforced, {row}}; }

TEST(RdramTiming, DefaultTableIsTheDataBooks) { EXPECT_EQ(timing(v1::RdramConfig()).rows(), kExpected); }

TEST(RdramTiming, RefusesARowThatTheModelWouldIgnore) {
  EXPECT_THROW(table({"tX", kRead, kActivate, kBank, 3}), std::invalid_argument);
  EXPECT_THROW(table({"tX", kPrecharge, kActivate, kDevice, 3}), std::invalid_argument);
}

TEST(RdramTiming, HonoursThePairsOfItsTableAndNoOthers) { dram::expect_enforced<Rules>(kExpected); }

// A packet at 200 takes its four clocks; of those before, a machine word of places up to 206 is known.
TEST(GapWires, GiveTheFirstGapFromTheirHorizonOn) {
  dram::GapWires<4> wires;
  EXPECT_EQ(wires.probe(17), 17u);
  wires.reserve(200);
  EXPECT_EQ(wires.horizon(), 143u);
  EXPECT_EQ(wires.probe(10), 143u);
  EXPECT_EQ(wires.probe(196), 196u);
  for (Tcycle t = 197; t <= 203; ++t) EXPECT_EQ(wires.probe(t), 204u) << t;
  EXPECT_EQ(wires.probe(204), 204u);
  wires.reserve(192);
  EXPECT_EQ(wires.horizon(), 143u);
  EXPECT_EQ(wires.probe(189), 196u);
  EXPECT_EQ(wires.probe(188), 188u);
  dram::GapWires<1> commands;
  commands.reserve(200);
  EXPECT_EQ(commands.horizon(), 137u);
  EXPECT_EQ(commands.probe(136), 137u);
  EXPECT_EQ(commands.probe(200), 201u);
  commands.reserve(199);
  EXPECT_EQ(commands.probe(199), 201u);
}

TEST(RdramTiming, DataNeverOverlapWhereWritesAreSlowerThanReads) {
  v1::RdramConfig config;
  config.set_t_cwd(11);
  const dram::ConstraintTable slow = timing(config);
  EXPECT_EQ(slow.delay(kChannel, kWrite, kRead), 7u);
  EXPECT_EQ(slow.delay(kChannel, kRead, kWrite), 4u);
}

class RdramConstraint : public testing::TestWithParam<Constraint> {};

// When `row.to` may begin in a device that knows only this row, after `row.from` began at `t`.
Tcycle ready_in_device(const Constraint& row, Tcycle t) {
  Device device(table(row));
  const int from = 5, to = row.scope == kBank ? 5 : row.scope == kNeighbour ? 6 : 12;
  const auto prepare = [&device](Command command, int bank) {
    const bool opens = command == kActivate || command == kRefresh;
    if (!opens && device.open_row(bank) < 0) device.issue(kActivate, {bank, 7}, 0);
    if (opens && device.open_row(bank) != kClosed) device.issue(kPrecharge, {bank}, 0);
  };
  // Both banks are brought to their states long before, so that only what is issued at `t` counts.
  prepare(row.from, from);
  if (to != from) prepare(row.to, to);
  device.issue(row.from, {from, 7}, t);
  // The state must allow what is asked for; where it does not, only the time is of interest.
  return std::max(t, device.probe(row.to, {to, 7}, t));
}

Tcycle ready_on_wires(const Constraint& row, Tcycle t) {
  dram::GapWires<kPacket> rows;
  rows.reserve(t);
  dram::ColumnWires<false> columns(table(row));
  if (row.from == kRead || row.from == kWrite) columns.reserve(row.from, 0, t);
  if (row.to == kRead || row.to == kWrite) return columns.probe(row.to, 0, t);
  if (row.to == kData) return columns.data(row.from, t);
  return rows.probe(t);
}

TEST_P(RdramConstraint, BlocksOneCycleEarlierAndNotAtItsTime) {
  constexpr Tcycle kStart = 1000;
  const Constraint& row = GetParam();
  if (row.scope == kChannel) {
    EXPECT_EQ(ready_on_wires(row, kStart), kStart + row.cycles);
    return;
  }
  // ACT to ACT of one bank needs a precharge between, which this table lets come at once.
  if (row.scope == kBank && row.from != kPrecharge && (row.to == kActivate || row.to == kRefresh)) {
    Device device(table(row));
    device.issue(row.from, {5, 7}, kStart);
    device.issue(kPrecharge, {5}, kStart + 1);
    EXPECT_GT(device.probe(row.to, {5, 7}, kStart + row.cycles - 1), kStart + row.cycles - 1);
    EXPECT_EQ(device.probe(row.to, {5, 7}, kStart + row.cycles), kStart + row.cycles);
    return;
  }
  EXPECT_EQ(ready_in_device(row, kStart), kStart + row.cycles);
}

INSTANTIATE_TEST_SUITE_P(Row, RdramConstraint, testing::ValuesIn(kExpected), dram::name_of_row);

}  // namespace
}  // namespace gicube::emu::rdram
