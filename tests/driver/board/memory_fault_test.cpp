// RDRAM errors that the board detects, and those that only verify_volume() finds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "temporary_directory.h"
#include "test_board.h"

namespace gicube {
namespace {

using reference::BoxVolume;
using reference::front_view;
using reference::kSmallBlocks;
using reference::open_board;
using reference::step_function;
using reference::TemporaryDirectory;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::ThrowsMessage;

// A board with 4^3 blocks, of which the box touches the middle ones.
Board loaded(const std::string& uri) {
  Board board = open_board(uri);
  board.set_transfer_function(step_function(0.5));
  board.load_volume(BoxVolume(32, 8, 23).view());
  return board;
}

// Where the fault hits the first message after loaded().
class FaultyBoard {
 public:
  explicit FaultyBoard(const std::string& kind) {
    // Its number is that of the messages so far, which a first run counts by hitting each.
    std::ofstream(folder_.file("count")) << "random { kinds: duplicate mean_messages: 1 direction: down }";
    {
      Board board = loaded(uri("count"));
      board.counters();
    }
    std::ifstream log(folder_.file("count.log"));
    int messages = 0;
    for (std::string line; std::getline(log, line);) ++messages;
    std::ofstream(folder_.file("plan")) << "fault { direction: down message: " << messages << " kind: " << kind << " }";
  }
  std::string uri(const std::string& plan = "plan") const {
    return std::string(kSmallBlocks) + "&faults=" + folder_.file(plan) + "&fault_log=" + folder_.file(plan + ".log");
  }

 private:
  TemporaryDirectory folder_;
};

TEST(MemoryFault, OfADetectedErrorIsThrownOnceAndHarmsNothing) {
  const FaultyBoard faulty("memory_detected block: 2 bit: 40");
  Board sound = loaded(kSmallBlocks);
  const Image expected = sound.render(front_view(32));
  Board board = loaded(faulty.uri());
  board.counters();
  EXPECT_THAT([&] { board.render(front_view(32)); }, ThrowsMessage<MemoryFault>(HasSubstr("word 1")));
  EXPECT_EQ(board.render(front_view(32)), expected);
  EXPECT_THAT(board.verify_volume(), IsEmpty());
}

TEST(MemoryFault, OfASilentErrorIsFoundByVerifyingAndMendedByLoading) {
  // The first of the blocks that are stored, the highest bit of a density.
  const FaultyBoard faulty("memory_silent block: 0 bit: 18371");
  Board sound = loaded(kSmallBlocks);
  const Image expected = sound.render(front_view(32));
  Board board = loaded(faulty.uri());
  board.counters();
  ASSERT_THAT(board.verify_volume(), SizeIs(1));
  EXPECT_NE(board.render(front_view(32)), expected);
  board.load_volume(BoxVolume(32, 8, 23).view());
  EXPECT_THAT(board.verify_volume(), IsEmpty());
  EXPECT_EQ(board.render(front_view(32)), expected);
}

TEST(VerifyVolume, ASoundVolumeHasNoDamagedBlock) {
  Board board = loaded(kSmallBlocks);
  EXPECT_THAT(board.verify_volume(), IsEmpty());
  board.load_volume(BoxVolume(20, 8, 12).view());
  EXPECT_THAT(board.verify_volume(), IsEmpty());
}

TEST(VerifyVolume, TheSimulatedHostWaitsForTheReading) {
  Board board = loaded(kSmallBlocks);
  const Picoseconds begin = board.now();
  board.verify_volume();
  // Slabs one block thick: a middle processor has 9 stored blocks at least, of 512 / 4 packets, 10 ns each.
  EXPECT_GT(board.now() - begin, 9 * 128 * Picoseconds{10'000});
  EXPECT_LT(board.now() - begin, 2 * 16 * 128 * Picoseconds{10'000});
}

TEST(VerifyVolume, NeedsAVolume) {
  Board board = open_board();
  EXPECT_THAT([&] { board.verify_volume(); }, ThrowsMessage<Rejected>(HasSubstr("load_volume")));
}

}  // namespace
}  // namespace gicube
