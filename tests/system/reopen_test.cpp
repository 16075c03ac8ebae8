// Boards over a Unix socket whose connections break, whose processes die and whose owners change.
#include <signal.h>
#include <unistd.h>

#include "board_process.h"
#include "temporary_directory.h"
#include "test.h"
#include "test_board.h"

namespace gicube::system_test {
namespace {

using std::chrono::milliseconds;

class Reopen : public testing::Test {
 protected:
  // A board process on the same socket as the last one.
  void start(const std::string& plan = "", const std::vector<std::string>& more = {}) {
    process_.reset();
    std::vector<std::string> arguments{
        "--listen", "unix:" + path_, "--quiet", "--set", "asic.block_voxels=8", "--set", "asic.max_volume_voxels=64"};
    if (!plan.empty()) {
      const std::string file = folder_.file("plan");
      std::ofstream(file) << plan;
      arguments.insert(arguments.end(), {"--faults", file});
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    process_ = std::make_unique<BoardProcess>(arguments);
    ASSERT_THAT(process_->read_line(), HasSubstr("ready"));
  }
  Board open(OpenOptions options = {}) {
    if (options.watchdog == OpenOptions().watchdog) options.watchdog = std::chrono::seconds(30);
    return Board::open("unix:" + path_, options);
  }
  static void load(Board& board) { load_box(board); }
  static std::vector<HostRay> rays(std::uint32_t count) {
    std::vector<HostRay> list;
    for (std::uint32_t i = 0; i < count; ++i) {
      list.push_back({.id = i, .position = {i % 31 + 0.25, i / 31 % 31 + 0.25, 0}, .direction = {0, 0, 1}});
    }
    return list;
  }
  // What an application sees of a session: pictures, rays, simulated times.
  struct Story {
    Image image;
    std::vector<TracedRay> rays;
    Picoseconds end = 0;
  };
  static Story play(Board& board) {
    Story story;
    load(board);
    const Ticket first = board.submit(rays(9000)), second = board.submit(rays(100));
    story.image = board.render(front_view(32));
    for (const Ticket ticket : {first, second}) {
      for (const TracedRay& ray : board.receive(ticket).rays) story.rays.push_back(ray);
    }
    story.end = board.now();
    return story;
  }
  static void expect_same(const Story& got, const Story& expected) {
    EXPECT_EQ(got.end, expected.end);
    EXPECT_TRUE(got.image == expected.image);
    ASSERT_EQ(got.rays.size(), expected.rays.size());
    for (std::size_t i = 0; i < got.rays.size(); ++i) {
      ASSERT_EQ(got.rays[i].id, expected.rays[i].id);
      ASSERT_EQ(got.rays[i].opacity, expected.rays[i].opacity);
      ASSERT_EQ(got.rays[i].position.z, expected.rays[i].position.z);
    }
  }

  reference::TemporaryDirectory folder_;
  std::string path_ = folder_.file("board");
  std::unique_ptr<BoardProcess> process_;
};

TEST_F(Reopen, ASessionThatResumesByItselfSeesNothingOfLostDamagedAndDoubledMessages) {
  start();
  Board quiet = open();
  const Story expected = play(quiet);
  std::string plan;
  for (const char* kind : {"drop", "corrupt bit: 400", "duplicate", "link_loss", "corrupt bit: 100"}) {
    static int n = 0;
    ++n;
    plan += "fault { direction: down message: " + std::to_string(7 * n) + " kind: " + kind + " }\n";
    plan += "fault { direction: up message: " + std::to_string(2 * n + 1) + " kind: " + kind + " }\n";
  }
  start(plan);
  OpenOptions options;
  options.reopen_attempts = 5;
  Board board = open(options);
  expect_same(play(board), expected);
}

TEST_F(Reopen, ManyRandomFaultsChangeNoRayAndNoPicosecond) {
  Board quiet = Board::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64");
  load(quiet);
  start("random { seed: 5 kinds: [drop, corrupt, duplicate, link_loss, delay] mean_messages: 20 max_delay_ms: 2 }");
  OpenOptions options;
  options.reopen_attempts = 100;
  options.watchdog = std::chrono::seconds(2);
  Board board = open(options);
  load(board);
  quiet.host_compute(std::max(board.now(), quiet.now()) - quiet.now());
  board.host_compute(quiet.now() - board.now());
  for (int i = 0; i < 60; ++i) {
    const auto batch = rays(static_cast<std::uint32_t>(1 + 37 * i));
    const Ticket ours = board.submit(batch), theirs = quiet.submit(batch);
    const RayBatch got = board.receive(ours), expected = quiet.receive(theirs);
    ASSERT_EQ(got.completed, expected.completed) << i;
    ASSERT_EQ(got.rays.size(), expected.rays.size());
    for (std::size_t k = 0; k < got.rays.size(); ++k) {
      ASSERT_EQ(got.rays[k].id, expected.rays[k].id);
      ASSERT_EQ(got.rays[k].opacity, expected.rays[k].opacity);
    }
  }
  EXPECT_EQ(board.now(), quiet.now());
}

TEST_F(Reopen, ABatchThatWasNotSubmittedIsNotTracedWhenTheSessionGoesOn) {
  bool lost_within = false;
  for (int message = 5; message < 200 && !lost_within; message += 5) {
    start("fault { direction: down message: " + std::to_string(message) + " kind: link_loss }");
    std::optional<Board> board;
    try {
      board = open({.max_rays = 4096});  // each command of submit() waits for the one before, and sees the loss
      load(*board);
    } catch (const Error&) {  // too early
      continue;
    }
    Ticket ticket;
    try {
      ticket = board->submit(rays(40'000));
    } catch (const DeviceLost&) {
      lost_within = true;
      ASSERT_TRUE(board->reopen().resumed);
      ticket = board->submit(rays(40'000));
    }
    if (!lost_within) continue;
    EXPECT_EQ(board->receive(ticket).rays.size(), 40'000u);
    board->counters();  // after all that was sent
    EXPECT_THAT(board->poll(), IsEmpty());
  }
  EXPECT_TRUE(lost_within);
}

TEST_F(Reopen, AfterALinkLossTheSessionGoesOnAndEachBatchComesOnce) {
  start("fault { direction: up message: 40 kind: link_loss }");
  Board board = open();
  load(board);
  const Ticket ticket = board.submit(rays(5000));
  const auto lose = [&] {
    for (int i = 0; i < 100; ++i) board.counters();
  };
  try {
    lose();
    ADD_FAILURE() << "the link was not lost";
  } catch (const DeviceLost& error) {
    EXPECT_EQ(error.cause(), Loss::kClosed);
    EXPECT_THAT(error.what(), HasSubstr("Board::reopen() connects again, gicube-smi doctor unix:/"));
  }
  EXPECT_THROW(board.receive(ticket), DeviceLost) << "until it is opened again";
  const Reopened reopened = board.reopen();
  EXPECT_TRUE(reopened.resumed);
  EXPECT_TRUE(reopened.volume);
  const RayBatch batch = board.receive(ticket);
  ASSERT_EQ(batch.rays.size(), 5000u);
  for (std::uint32_t i = 0; i < 5000; ++i) ASSERT_EQ(batch.rays[i].id, i);
  EXPECT_THROW(board.receive(ticket), BadArgument);
}

TEST_F(Reopen, ABoardThatHangsTimesOutAndItsSessionGoesOn) {
  start("fault { direction: up message: 40 kind: hang }");
  OpenOptions options;
  options.watchdog = milliseconds(300);
  Board board = open(options);
  load(board);
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) board.counters();
      },
      TimedOut);
  EXPECT_TRUE(board.reopen().resumed);
  EXPECT_NO_THROW(board.render(front_view(32)));
}

TEST_F(Reopen, AKilledBoardIsReplacedByANewOneWithVolumeTablesAndBatches) {
  start();
  OpenOptions options;
  options.keep_volume = true;
  Board board = open(options);
  load(board);
  const Image before = board.render(front_view(32));
  const Ticket ticket = board.submit(rays(5000));
  process_->send_signal(SIGKILL);
  process_->exit_code();
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) board.counters();
      },
      DeviceLost);
  EXPECT_THROW(board.reopen(), OpenFailed) << "nobody is there";
  const Picoseconds lost_at = board.now();
  start();
  const Reopened reopened = board.reopen();
  EXPECT_FALSE(reopened.resumed);
  EXPECT_TRUE(reopened.volume);
  EXPECT_GE(board.now(), lost_at);
  EXPECT_EQ(board.receive(ticket).rays.size(), 5000u);
  EXPECT_THROW(board.read_framebuffer(), Rejected);
  const Image after = board.render(front_view(32));
  EXPECT_TRUE(after == before);
}

TEST_F(Reopen, BatchesAreSentAgainAsTheyWereSampledFirst) {
  View coarse = front_view(32), fine = front_view(32);
  coarse.step = 3;
  coarse.shade = false;
  fine.step = 0.25;
  fine.opacity_threshold = 0.5;
  const auto submit_both = [&](Board& board) {
    load(board);
    const Ticket first = board.submit(rays(900), {.step = coarse.step, .sampling = sampling_of(coarse)});
    return std::pair(first, board.submit(rays(900), {.step = fine.step, .sampling = sampling_of(fine)}));
  };
  start();
  std::vector<TracedRay> expected;
  {
    Board quiet = open();
    const auto [first, second] = submit_both(quiet);
    for (const Ticket ticket : {first, second}) {
      for (const TracedRay& ray : quiet.receive(ticket).rays) expected.push_back(ray);
    }
  }
  OpenOptions options;
  options.keep_volume = true;
  Board board = open(options);
  const auto [first, second] = submit_both(board);
  start();  // the board that has the rays is gone
  EXPECT_THROW(board.counters(), DeviceLost);
  EXPECT_FALSE(board.reopen().resumed);
  std::vector<TracedRay> got;
  for (const Ticket ticket : {first, second}) {
    for (const TracedRay& ray : board.receive(ticket).rays) got.push_back(ray);
  }
  EXPECT_TRUE(got == expected);
  EXPECT_NE(expected[900 / 2].opacity, expected[900 + 900 / 2].opacity);
}

TEST_F(Reopen, WithoutAKeptVolumeTheBatchesWaitForTheNextOne) {
  start();
  Board board = open();
  load(board);
  const Ticket ticket = board.submit(rays(50));
  process_->send_signal(SIGKILL);
  process_->exit_code();
  start();
  const Reopened reopened = board.reopen();
  EXPECT_FALSE(reopened.resumed);
  EXPECT_FALSE(reopened.volume);
  EXPECT_THROW(board.receive(ticket), Rejected);
  EXPECT_THROW(board.render(front_view(32)), Rejected);
  board.load_volume(BoxVolume(32, 8, 23).view());
  EXPECT_EQ(board.receive(ticket).rays.size(), 50u);
}

TEST_F(Reopen, ABusyBoardNamesItsOwnerAndForceTakesIt) {
  start();
  Board owner = open();
  load(owner);
  EXPECT_THROWS(BoardBusy, "process " + std::to_string(::getpid()) + " since ", open());
  OpenOptions options;
  options.force = true;
  Board thief = open(options);
  try {
    owner.counters();
    ADD_FAILURE() << "the owner still has the board";
  } catch (const DeviceLost& error) {
    EXPECT_EQ(error.cause(), Loss::kTakenOver);
    EXPECT_THAT(error.what(), HasSubstr("took the board by force"));
  }
  EXPECT_THROW(thief.render(front_view(32)), Rejected) << "it has no volume: it was reset";
  EXPECT_THROW(owner.reopen(), BoardBusy);
}

TEST_F(Reopen, ClientsThatWaitGetTheBoardInTheirOrder) {
  start();
  auto owner = std::make_unique<Board>(open());
  std::mutex mutex;
  std::vector<int> order;
  std::vector<std::thread> clients;
  for (int i = 0; i < 4; ++i) {
    clients.emplace_back([&, i] {
      OpenOptions options;
      options.wait_for_board = std::chrono::seconds(30);
      const Board board = open(options);
      const std::lock_guard lock(mutex);
      order.push_back(i);
    });
    std::this_thread::sleep_for(milliseconds(150));  // so that they stand in line in this order
  }
  owner.reset();
  for (std::thread& client : clients) client.join();
  EXPECT_THAT(order, ElementsAre(0, 1, 2, 3));
}

TEST_F(Reopen, AClientThatWaitsLongEnoughIsToldThatTheBoardIsBusy) {
  start();
  const Board owner = open();
  OpenOptions options;
  options.wait_for_board = milliseconds(400);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_THROW(open(options), BoardBusy);
  EXPECT_GE(std::chrono::steady_clock::now() - begin, milliseconds(400));
  options.wait_for_board = milliseconds(-1);
  EXPECT_THROWS(BadArgument, "wait_for_board", open(options));
}

TEST_F(Reopen, BoardsOfOneProcessAreStrangersToEachOther) {
  start("", {"--boards", "2"});
  Board first = open(), second = Board::open("unix:" + path_ + ".1");
  Board alone = Board::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64");
  load(first);
  EXPECT_THROW(second.render(front_view(32)), Rejected);
  load(second);
  load(alone);
  const Image expected = alone.render(front_view(32));
  for (Board* board : {&first, &second}) {
    EXPECT_TRUE(board->render(front_view(32)) == expected);
    EXPECT_EQ(board->now(), alone.now());
  }
  OpenOptions force;
  force.force = true;
  const Board thief = open(force);
  EXPECT_THROW(first.counters(), DeviceLost);
  EXPECT_NO_THROW(second.counters());
}

TEST_F(Reopen, WithoutResumingABrokenConnectionIsTheEndOfTheSession) {
  start("fault { direction: up message: 40 kind: link_loss }", {"--resume-seconds", "0"});
  OpenOptions options;
  options.reopen_attempts = 3;
  Board board = open(options);
  load(board);
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) board.counters();
      },
      DeviceLost);
  const Reopened reopened = board.reopen();
  EXPECT_FALSE(reopened.resumed);
  EXPECT_FALSE(reopened.volume);
}

TEST_F(Reopen, ABoardWhoseClientIsGoneBelongsToTheNextAtOnce) {
  start("fault { direction: up message: 20 kind: link_loss }");
  Board lost = open();
  EXPECT_THROW(
      {
        for (int i = 0; i < 100; ++i) lost.counters();
      },
      DeviceLost);
  Board next = open();
  load(next);
  EXPECT_THROW(lost.reopen(), BoardBusy);
  EXPECT_NO_THROW(next.render(front_view(32)));
}

TEST_F(Reopen, BoardsInRealTimeAnswerNoEarlierThanTheirSimulatedTime) {
  start("", {"--set", "pace=realtime", "--set", "bus.model=pci33"});
  const auto begin = std::chrono::steady_clock::now();
  Board board = open();
  load(board);
  board.host_compute(50'000'000'000);  // 50 ms
  board.render(front_view(32));
  const auto took = std::chrono::steady_clock::now() - begin;
  EXPECT_GE(board.now(), 50'000'000'000u);
  EXPECT_GE(std::chrono::duration_cast<std::chrono::nanoseconds>(took).count() + 1,
            static_cast<std::int64_t>(board.now() / 1000));
}

TEST_F(Reopen, APrivateBoardIsStartedAgain) {
  Board board = Board::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64");
  EXPECT_TRUE(board.reopen().resumed) << "it is not lost";
}

}  // namespace
}  // namespace gicube::system_test
