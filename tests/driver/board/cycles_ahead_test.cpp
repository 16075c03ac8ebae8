// The cycle level's fast way on boards as users have them: processes of gicube-board, whose debugger nobody uses.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

TEST(CyclesAhead, MostCyclesOfAServedBoardGoTheFastWay) {
  Board board = Board::open("emu:?fidelity=cycle");
  board.load_volume(BoxVolume(96, 4, 91).view());
  board.set_transfer_function(step_function(0.01));
  View view = front_view(96);
  view.width = view.height = 128;
  board.render(view);
  const Counters counters = board.counters();
  const std::uint64_t processors = 4, all = counters.value("asic.cycles") * processors;
  EXPECT_GT(counters.value("emulator.cycles_ahead"), all / 2);
  EXPECT_LE(counters.value("emulator.cycles_ahead"), all);
}

}  // namespace
}  // namespace gicube
