// What goes wrong with one of several boards, and with what a group is asked for.
#include <signal.h>

#include "../test_board.h"
#include "gicube/board_group.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::reference {
namespace {

const std::string kGroupOfThree = std::string(kSmallBlocks) + "&boards=3";

// As open_board_process(): the boards' ids in the order in which they were opened.
struct GroupProcesses {
  BoardGroup group;
  std::vector<pid_t> ids;
};

GroupProcesses open_group_processes(const GroupOptions& options) {
  const TemporaryDirectory folder;
  const std::string script = folder.file("board"), ids = folder.file("ids");
  std::ofstream(script) << "#!/bin/sh\necho $$ >> " << ids << "\nexec " GICUBE_BIN_DIR "/gicube-board \"$@\"\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  ::setenv("GICUBE_BOARD", script.c_str(), 1);
  GroupProcesses opened{BoardGroup::open(kGroupOfThree, options), {}};
  ::setenv("GICUBE_BOARD", GICUBE_BIN_DIR "/gicube-board", 1);
  std::ifstream from(ids);
  for (pid_t id = 0; from >> id;) opened.ids.push_back(id);
  return opened;
}

TEST(GroupFailure, OfAKilledBoardIsNamedAndAllIsThereAgainOnceItIsReopened) {
  auto [group, ids] = open_group_processes({.board = {.keep_volume = true}});
  ASSERT_EQ(ids.size(), 3u);
  group.on_all([](Board& board) { load_box(board, 0.3); });
  View view = front_view(32);
  const Image expected = group.render(view);
  const std::vector<HostRay> rays(100, {.position = {12, 12, 0}, .direction = {0, 0, 1}});
  const RayBatch traced = group.trace(rays);

  ::kill(ids[1], SIGKILL);
  const auto is_named = AllOf(StartsWith("board 2 of 3 (emu:): "), HasSubstr("signal 9"));
  EXPECT_THAT([&] { group.render(view); }, ThrowsMessage<DeviceLost>(is_named));
  EXPECT_THAT([&] { group.trace(rays); }, ThrowsMessage<DeviceLost>(is_named));
  EXPECT_THAT([&] { group.on_all([](Board& board) { board.dims(); }); }, ThrowsMessage<DeviceLost>(is_named));
  EXPECT_THAT([&] { group.counters(); }, ThrowsMessage<DeviceLost>(is_named));
  EXPECT_EQ(group.board(0).dims(), (Dims{32, 32, 32}));
  EXPECT_EQ(group.board(2).dims(), (Dims{32, 32, 32}));

  EXPECT_TRUE(group.board(1).reopen().volume);
  EXPECT_EQ(group.render(view), expected);
  EXPECT_EQ(group.trace(rays).rays, traced.rays);
  for (const BoardTime& time : group.times()) {
    EXPECT_EQ(time.bus + time.work + time.bus_wait + time.skew, group.now());
  }
}

TEST(GroupFailure, OfOneBoardLeavesWhatTheOthersHaveDone) {
  BoardGroup group = BoardGroup::open(kGroupOfThree);
  const BoxVolume volume(32, 8, 23);
  const auto load_all_but_one = [&](Board& board, std::size_t index) {
    if (index != 1) board.load_volume(volume.view());
  };
  group.on_all(load_all_but_one);
  EXPECT_THAT([&] { group.render(front_view(32)); },
              ThrowsMessage<Rejected>(AllOf(StartsWith("board 2 of 3 (emu:): "), HasSubstr("load_volume()"))));
  group.on_all([&](Board& board, std::size_t index) {
    if (index == 1) board.load_volume(volume.view());
  });
  EXPECT_EQ(group.render(front_view(32)).height, 32);
  struct Own {};
  const auto throw_own = [](Board&, std::size_t index) {
    if (index == 2) throw Own();
  };
  EXPECT_THROW(group.on_all(throw_own), Own);
}

TEST(GroupFailure, OfARayIsNamedByTheCallersNumber) {
  BoardGroup group = BoardGroup::open(kGroupOfThree);
  const BoxVolume volume(32, 8, 23);
  group.on_all([&](Board& board) { board.load_volume(volume.view()); });
  std::vector<HostRay> rays(1000, {.position = {12, 12, 0}, .direction = {0, 0, 1}});
  rays[777].position.x = 99;
  EXPECT_THROWS(BadArgument, "rays[777].position.x", group.trace(rays));
}

TEST(GroupFailure, OfAddressesAndOptionsSaysWhatWasExpected) {
  const auto open = [](const std::string& address) { return [address] { BoardGroup::open(address); }; };
  EXPECT_THAT(open("emu:?boards=0"),
              ThrowsMessage<BadArgument>(HasSubstr("URI option boards: expected a number from 1 to 64")));
  EXPECT_THAT(open("emu:?boards=65"), ThrowsMessage<BadArgument>(HasSubstr("boards")));
  EXPECT_THAT(open("emu:?boards=2x"), ThrowsMessage<BadArgument>(HasSubstr("boards")));
  EXPECT_THAT(open("emu:?boards=2&boards=2"), ThrowsMessage<BadArgument>(HasSubstr("once")));
  EXPECT_THAT(open("emu:?buses=two"), ThrowsMessage<BadArgument>(HasSubstr("shared or own")));
  EXPECT_THAT(open("emu:?boards=2&colour=red"), ThrowsMessage<BadArgument>(HasSubstr("URI option")));
  EXPECT_THAT(open("emu:?boards=2&bus=agp2x"), ThrowsMessage<BadArgument>(HasSubstr("has one card")));
  EXPECT_EQ(BoardGroup::open("emu:?boards=2&bus=agp2x&buses=own").size(), 2u);
  EXPECT_EQ(BoardGroup::open("emu:?bus=agp2x").size(), 1u);
  EXPECT_THROW(BoardGroup::open(std::vector<std::string>{}), BadArgument);
  EXPECT_THAT(
      [] {
        BoardGroup::open(std::vector<std::string>{"emu:", "unix:/nowhere"});
      },
      ThrowsMessage<OpenFailed>(StartsWith("board 2 of 2 (unix:/nowhere): ")));
  EXPECT_THAT(open("emu:?boards=2&trace=file"), ThrowsMessage<BadArgument>(HasSubstr("one board, since it writes")));
  EXPECT_THROWS(BadArgument, "board.capture", BoardGroup::open("emu:?boards=2", {.board = {.capture = "file"}}));
  BoardGroup group = BoardGroup::open("emu:?boards=2");
  EXPECT_THROWS(BadArgument, "less than 2", group.board(2));
}

}  // namespace
}  // namespace gicube::reference
