#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <utility>

#include "test_board.h"

namespace gicube {
namespace {

using reference::open_board;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Open, APrivateBoardTellsWhatItIs) {
  const Board board = open_board("emu:?set=asic.processors=8&set=asic.block_voxels=16&set=asic.max_volume_voxels=128");
  const BoardInfo& info = board.info();
  EXPECT_EQ(info.protocol_major, 2);
  EXPECT_EQ(info.fidelity, Fidelity::kFunctional);
  EXPECT_EQ(info.processors, 8);
  EXPECT_EQ(info.block_voxels, 16);
  EXPECT_EQ(info.max_volume_voxels, 128);
  EXPECT_EQ(info.queue_rays, 256);
  EXPECT_EQ(info.core_khz, 100'000u);
  EXPECT_NE(info.config_hash, 0u);
  EXPECT_EQ(info.vendor_id, 0x4749);
  EXPECT_TRUE(info.host_rays);
}

TEST(Open, TheAgpCapabilityIsFoundInConfigurationSpace) {
  EXPECT_FALSE(open_board("emu:?bus=pci33").info().agp);
  EXPECT_TRUE(open_board("emu:?bus=agp2x").info().agp);
}

TEST(Open, AConfigurationFaultIsABadArgumentInTheBoardsWords) {
  EXPECT_THAT([] { open_board("emu:?set=asic.processors=99&set=dsp.clock_khz=1"); },
              ThrowsMessage<BadArgument>(::testing::AllOf(HasSubstr("asic.processors"), HasSubstr("dsp.clock_khz"))));
  EXPECT_THAT([] { open_board("emu:?set=asic.wings=2"); }, ThrowsMessage<BadArgument>(HasSubstr("wings")));
  EXPECT_THAT([] { open_board("emu:?config=/nowhere"); }, ThrowsMessage<BadArgument>(HasSubstr("/nowhere")));
}

TEST(Open, AMissingSocketIsNamed) {
  EXPECT_THAT([] { open_board("unix:/nowhere/board.sock"); },
              ThrowsMessage<OpenFailed>(HasSubstr("/nowhere/board.sock")));
  EXPECT_THROW(open_board("unix:/" + std::string(200, 'x')), BadArgument);
}

TEST(Open, ANegativeWatchdogIsRefused) {
  EXPECT_THROW(Board::open("emu:", {.watchdog = std::chrono::milliseconds(-1)}), BadArgument);
}

TEST(Open, ABoardMayBeMovedAndReplaced) {
  Board board = open_board("emu:?set=asic.processors=2");
  Board other = std::move(board);
  EXPECT_EQ(other.info().processors, 2);
  other = open_board("emu:?set=asic.processors=4");
  EXPECT_EQ(other.info().processors, 4);
  EXPECT_NO_THROW(other.counters());
}

TEST(Open, HostWorkMovesTheSimulatedClockByItsDuration) {
  Board board = open_board();
  const Picoseconds before = board.now();
  board.host_compute(12'345);
  EXPECT_EQ(board.now(), before + 12'345);
}

TEST(Open, TheSameCallsTakeTheSameSimulatedTime) {
  const auto run = [] {
    Board board = open_board();
    board.counters();
    return board.now();
  };
  const Picoseconds first = run();
  EXPECT_GT(first, 0u);
  EXPECT_EQ(run(), first);
}

TEST(Open, CountersSeeWhatTheHostHasWritten) {
  Board board = open_board();
  const reference::BoxVolume volume(32, 8, 23);
  const Counters before = board.counters();
  board.load_volume(volume.view());
  const Counters window = board.counters() - before;
  // One block of 36-bit voxels and the gradient LUT are the larger part.
  EXPECT_GT(window.value("bus.down.bytes"), 32u * 32 * 32 * 36 / 8 + 8192);
}

}  // namespace
}  // namespace gicube
