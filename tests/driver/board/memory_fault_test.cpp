// RDRAM errors that the board detects, and those that only verify_volume() finds.
#include "temporary_directory.h"
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

using reference::TemporaryDirectory;

// A board with 4^3 blocks, of which the box touches the middle ones.
Board loaded(const std::string& uri) {
  Board board = Board::open(uri);
  load_box(board, 0.5);
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
  EXPECT_THROWS(MemoryFault, "word 1", board.render(front_view(32)));
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
  Board board = Board::open("emu:");
  EXPECT_THROWS(Rejected, "load_volume", board.verify_volume());
}

}  // namespace
}  // namespace gicube
