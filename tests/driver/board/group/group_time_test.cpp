// What time the calls of several boards take: closed forms of a shared bus, and where each board's time goes.
#include "../test_board.h"
#include "board/group/shared_bus.h"
#include "gicube/board_group.h"
#include "test.h"

namespace gicube::reference {
namespace {

using Phases = std::vector<BusPhase>;

TEST(SharedBus, LetsBoardsThatDoNotFillItTogetherGoOnAsIfTheyWereAlone) {
  EXPECT_EQ(done_on_shared_bus(std::vector<Phases>{{{100, 50}}, {{80, 40}}, {}}),
            (std::vector<Picoseconds>{100, 80, 0}));
}

TEST(SharedBus, TakesAsLongForEqualTransfersAsTheyTakeOneAfterTheOther) {
  for (std::size_t boards = 1; boards <= 64; ++boards) {
    const auto done = done_on_shared_bus(std::vector<Phases>(boards, Phases{{1'000'000'007, 1'000'000'007}}));
    EXPECT_EQ(done, std::vector<Picoseconds>(boards, boards * 1'000'000'007));
  }
}

// Both go on at half speed until the shorter is done at 2 x 30; then the longer has 100 - 30 left.
TEST(SharedBus, IsFreeForTheRestOfALongerTransfer) {
  EXPECT_EQ(done_on_shared_bus(std::vector<Phases>{{{100, 100}}, {{30, 30}}}), (std::vector<Picoseconds>{130, 60}));
}

// The one that asks for a quarter gets it; the two others share three quarters of the bus, 3/8 each.
TEST(SharedBus, GivesThoseThatAskForLittleAllOfItAndDividesTheRest) {
  const auto done = done_on_shared_bus(std::vector<Phases>{{{3000, 750}}, {{300, 300}}, {{300, 300}}});
  EXPECT_EQ(done, (std::vector<Picoseconds>{3000, 800, 800}));
}

// Work without the bus hides in the other's transfers: 0..100 the first works while the second has the bus; then the
// first transfers alone.
TEST(SharedBus, IsTakenByOneBoardWhileAnotherWorks) {
  const auto done = done_on_shared_bus(std::vector<Phases>{{{100, 0}, {50, 50}}, {{100, 100}, {70, 0}}});
  EXPECT_EQ(done, (std::vector<Picoseconds>{150, 170}));
}

BoardGroup open_timed(int boards, const std::string& buses) {
  return BoardGroup::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64&threads=1&boards=" +
                          std::to_string(boards) + "&buses=" + buses);
}

Picoseconds sum(const BoardTime& time) { return time.bus + time.work + time.bus_wait + time.skew; }

// What a call takes, and the latest board's own share of bus and work in it.
template <typename Call>
std::pair<Picoseconds, BoardTime> taken(BoardGroup& group, const Call& call) {
  const Picoseconds begin = group.now();
  const BoardTime before = group.times()[0];
  call();
  const BoardTime after = group.times()[0];
  return {
      group.now() - begin,
      {after.bus - before.bus, after.work - before.work, after.bus_wait - before.bus_wait, after.skew - before.skew}};
}

TEST(GroupTime, OfNUploadsOnASharedBusIsNTimesThatOfOneAndOnOwnBusesThatOfOne) {
  const BoxVolume volume(64, 0, 63);
  const auto upload = [&](int boards, const std::string& buses) {
    BoardGroup group = open_timed(boards, buses);
    return taken(group, [&] { group.on_all([&](Board& board) { board.load_volume(volume.view()); }); });
  };
  const auto [one, of_one] = upload(1, "shared");
  ASSERT_GT(of_one.bus, one / 10 * 9);
  for (const int boards : {2, 4}) {
    const auto count = static_cast<Picoseconds>(boards);
    EXPECT_EQ(upload(boards, "own").first, one);
    const auto [shared, of_board] = upload(boards, "shared");
    // What is not on the bus, work, hides in the others' transfers, but for as much as all boards work at once.
    EXPECT_GE(shared, count * of_one.bus);
    EXPECT_LE(shared, count * one);
    EXPECT_EQ(of_board.bus, of_one.bus);
    EXPECT_EQ(of_board.bus_wait, shared - one);
  }
}

TEST(GroupTime, OfEachBoardAddsUpToTheClockWhateverItHasDone) {
  for (const std::string buses : {"shared", "own"}) {
    BoardGroup group = open_timed(3, buses);
    group.on_all([](Board& board) { load_box(board, 0.3); });
    group.render(front_view(32));
    group.board(1).host_compute(1'000'000);
    group.on_all([](Board& board, std::size_t index) { board.host_compute(index * 2'000'000); });
    group.trace(std::vector<HostRay>(999, {.position = {3, 3, 0}, .direction = {0, 0, 1}}));
    for (const BoardTime& time : group.times()) EXPECT_EQ(sum(time), group.now()) << buses;
    for (std::size_t i = 0; i < group.size(); ++i) EXPECT_EQ(group.board(i).now(), group.now());
    EXPECT_EQ(group.times()[0].bus_wait == 0, buses == "own");
  }
}

TEST(GroupTime, OfAPictureIsThatOfTheBoardWithMostWorkWhereEachHasItsBus) {
  BoardGroup group = open_timed(2, "own");
  group.on_all([](Board& board) { load_box(board, 0.3); });
  const auto before = group.times();
  const Picoseconds begin = group.now();
  View view = front_view(32);
  view.height = 31;  // 16 and 15 rows
  group.render(view);
  const auto after = group.times();
  Picoseconds most = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    most = std::max(most, after[i].bus + after[i].work - before[i].bus - before[i].work);
  }
  EXPECT_EQ(group.now() - begin, most);
  EXPECT_EQ(after[0].skew, before[0].skew);
  EXPECT_GT(after[1].skew, before[1].skew);
}

TEST(GroupTime, IsTheSameHoweverTheProcessesTakeTheirTurns) {
  const auto run = [](unsigned threads) {
    BoardGroup group = BoardGroup::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64&boards=3&threads=" +
                                        std::to_string(threads));
    group.on_all([](Board& board) { load_box(board, 0.3); });
    for (int i = 0; i < 5; ++i) group.render(front_view(32));
    return group.times();
  };
  const auto times = run(1);
  EXPECT_EQ(run(1), times);
  EXPECT_EQ(run(4), times);
}

}  // namespace
}  // namespace gicube::reference
