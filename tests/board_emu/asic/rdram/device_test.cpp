#include "asic/rdram/channel.h"

#include "test.h"

#include "probed_device.h"

namespace gicube::emu::rdram {
namespace {

using Device = dram::ProbedDevice<Rules>;
using enum Command;

const dram::ConstraintTable kTiming = timing(v1::RdramConfig());

TEST(RdramDevice, ActivatesOnlyWhereBankAndNeighboursArePrecharged) {
  Device device(kTiming);
  device.issue(kActivate, {5, 1}, 0);
  for (const Command opens : {kActivate, kRefresh}) {
    EXPECT_EQ(device.probe(opens, {4, 1}, 100), kNever);
    EXPECT_EQ(device.probe(opens, {5, 2}, 100), kNever);
    EXPECT_EQ(device.probe(opens, {6, 1}, 100), kNever);
    EXPECT_EQ(device.probe(opens, {3, 1}, 100), 100u);
    EXPECT_EQ(device.probe(opens, {7, 1}, 100), 100u);
  }
}

TEST(RdramDevice, TwoGroupsOfSixteenBanksShareNoSenseAmp) {
  Device device(kTiming);
  device.issue(kActivate, {15, 1}, 0);
  EXPECT_EQ(device.probe(kActivate, {16, 1}, 100), 100u);
  EXPECT_EQ(device.probe(kActivate, {14, 1}, 100), kNever);
  EXPECT_EQ(neighbours(0), 1u << 1);
  EXPECT_EQ(neighbours(31), 1u << 30);
  EXPECT_EQ(neighbours(16), 1u << 17);
}

TEST(RdramDevice, ReadsAndPrechargesOnlyAnOpenBank) {
  Device device(kTiming);
  EXPECT_EQ(device.probe(kRead, {3}, 0), kNever);
  EXPECT_EQ(device.probe(kPrecharge, {3}, 0), kNever);
  device.issue(kRefresh, {3}, 0);
  EXPECT_EQ(device.probe(kRead, {3}, 0), kNever) << "a refreshed row holds nobody's data";
  EXPECT_EQ(device.probe(kPrecharge, {3}, 0), 20u);
}

TEST(RdramDevice, ABankTurnsInTwentyEight) {
  Device device(kTiming);
  device.issue(kActivate, {3, 1}, 100);
  EXPECT_EQ(device.probe(kRead, {3}, 0), 107u);
  device.issue(kRead, {3}, 107);
  EXPECT_EQ(device.probe(kPrecharge, {3}, 0), 120u);
  device.issue(kPrecharge, {3}, 120);
  EXPECT_EQ(device.probe(kActivate, {3, 2}, 0), 128u);
  EXPECT_EQ(device.probe(kActivate, {4, 2}, 0), 128u) << "its neighbour waits for the shared sense amps";
}

TEST(RdramDevice, AsksChangeNothing) {
  Device device(kTiming);
  device.issue(kActivate, {3, 1}, 100);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(device.probe(kWrite, {3}, 0), 107u);
  EXPECT_EQ(device.open_row(3), 1);
  EXPECT_EQ(device.open_banks(), 1u << 3);
}

}  // namespace
}  // namespace gicube::emu::rdram
