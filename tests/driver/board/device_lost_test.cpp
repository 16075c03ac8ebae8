#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "test_board.h"

namespace gicube {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Lost, AfterTheBoardsProcessWasKilledEveryCallSaysSoAndANewBoardCanBeOpened) {
  Board first = reference::open_board();  // sets GICUBE_BOARD
  const std::string program = ::getenv("GICUBE_BOARD");
  std::string folder = (fs::temp_directory_path() / "gicube-lost-XXXXXX").string();
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  const std::string wrapper = folder + "/board", id_file = folder + "/id";
  std::ofstream(wrapper) << "#!/bin/sh\necho $$ > " << id_file << "\nexec " << program << " \"$@\"\n";
  ::chmod(wrapper.c_str(), 0700);

  ::setenv("GICUBE_BOARD", wrapper.c_str(), 1);
  Board board = Board::open("emu:");
  ::setenv("GICUBE_BOARD", program.c_str(), 1);
  pid_t id = 0;
  std::ifstream(id_file) >> id;
  fs::remove_all(folder);
  ASSERT_GT(id, 0);
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
