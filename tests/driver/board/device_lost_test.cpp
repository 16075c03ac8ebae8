#include <signal.h>

#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

TEST(Lost, AfterTheBoardsProcessWasKilledEveryCallSaysSoAndANewBoardCanBeOpened) {
  auto [board, id] = open_board_process();
  ::kill(id, SIGKILL);

  const BoxVolume volume(32, 8, 23);
  EXPECT_THROWS(DeviceLost, "signal 9", board.counters());
  EXPECT_THROW(board.load_volume(volume.view()), DeviceLost);
  EXPECT_THROW(board.set_transfer_function(step_function(1)), DeviceLost);
  EXPECT_THROW(board.submit(std::span<const HostRay>{}), DeviceLost);
  EXPECT_THROW(board.poll(), DeviceLost);
  EXPECT_EQ(board.info().processors, 4);
  board = Board::open("emu:");
  EXPECT_NO_THROW(board.load_volume(volume.view()));
}

}  // namespace
}  // namespace gicube
