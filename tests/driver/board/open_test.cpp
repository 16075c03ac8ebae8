#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

TEST(Open, APrivateBoardTellsWhatItIs) {
  const Board board = Board::open("emu:?set=asic.processors=8&set=asic.block_voxels=16&set=asic.max_volume_voxels=128");
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
  EXPECT_FALSE(Board::open("emu:?bus=pci33").info().agp);
  EXPECT_TRUE(Board::open("emu:?bus=agp2x").info().agp);
}

TEST(Open, AConfigurationFaultIsABadArgumentInTheBoardsWords) {
  EXPECT_THAT([] { Board::open("emu:?set=asic.processors=99&set=dsp.clock_khz=1"); },
              ThrowsMessage<BadArgument>(AllOf(HasSubstr("asic.processors"), HasSubstr("dsp.clock_khz"))));
  EXPECT_THROWS(BadArgument, "wings", Board::open("emu:?set=asic.wings=2"));
  EXPECT_THROWS(BadArgument, "/nowhere", Board::open("emu:?config=/nowhere"));
}

TEST(Open, AMissingSocketIsNamed) {
  EXPECT_THROWS(OpenFailed, "/nowhere/board.sock", Board::open("unix:/nowhere/board.sock"));
  EXPECT_THROW(Board::open("unix:/" + std::string(200, 'x')), BadArgument);
}

TEST(Open, ANegativeWatchdogIsRefused) {
  EXPECT_THROW(Board::open("emu:", {.watchdog = std::chrono::milliseconds(-1)}), BadArgument);
}

TEST(Open, ABoardMayBeMovedAndReplaced) {
  Board board = Board::open("emu:?set=asic.processors=2");
  Board other = std::move(board);
  EXPECT_EQ(other.info().processors, 2);
  other = Board::open("emu:?set=asic.processors=4");
  EXPECT_EQ(other.info().processors, 4);
  EXPECT_NO_THROW(other.counters());
}

TEST(Open, HostWorkMovesTheSimulatedClockByItsDuration) {
  Board board = Board::open("emu:");
  const Picoseconds before = board.now();
  board.host_compute(12'345);
  EXPECT_EQ(board.now(), before + 12'345);
}

TEST(Open, TheSameCallsTakeTheSameSimulatedTime) {
  const auto run = [] {
    Board board = Board::open("emu:");
    board.counters();
    return board.now();
  };
  const Picoseconds first = run();
  EXPECT_GT(first, 0u);
  EXPECT_EQ(run(), first);
}

TEST(Open, CountersSeeWhatTheHostHasWritten) {
  Board board = Board::open("emu:");
  const BoxVolume volume(32, 8, 23);
  const Counters before = board.counters();
  board.load_volume(volume.view());
  const Counters window = board.counters() - before;
  // One block of 36-bit voxels and the gradient LUT are the larger part.
  EXPECT_GT(window.value("bus.down.bytes"), 32u * 32 * 32 * 36 / 8 + 8192);
}

}  // namespace
}  // namespace gicube
