#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "test_board.h"

namespace gicube {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Lost, AfterTheBoardsProcessWasKilledEveryCallSaysSoAndANewBoardCanBeOpened) {
  auto [board, id] = reference::open_board_process();
  ::kill(id, SIGKILL);

  const reference::BoxVolume volume(32, 8, 23);
  EXPECT_THAT([&] { board.counters(); }, ThrowsMessage<DeviceLost>(HasSubstr("signal 9")));
  EXPECT_THROW(board.load_volume(volume.view()), DeviceLost);
  EXPECT_THROW(board.set_transfer_function(reference::step_function(1)), DeviceLost);
  EXPECT_THROW(board.submit(std::span<const HostRay>{}), DeviceLost);
  EXPECT_THROW(board.poll(), DeviceLost);
  EXPECT_EQ(board.info().processors, 4);
  board = Board::open("emu:");
  EXPECT_NO_THROW(board.load_volume(volume.view()));
}

}  // namespace
}  // namespace gicube
