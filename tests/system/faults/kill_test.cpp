// SIGKILL at random moments: who survives says so and goes on.
#include <signal.h>

#include "board_process.h"
#include "good_client.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::system_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr int kMoments = 100;
constexpr std::chrono::seconds kDeadline{20};  // of one answer: far above any that comes, also under a sanitizer

OpenOptions patient() {
  OpenOptions options;
  options.watchdog = kDeadline;
  options.keep_volume = true;
  return options;
}

std::vector<std::string> arguments(const std::string& path) {
  std::vector<std::string> all = small_board();
  all.insert(all.end(), {"--listen", "unix:" + path});
  return all;
}

class Kill : public testing::Test {
 protected:
  Kill() {
    BoardProcess process(arguments(path));
    process.read_line();
    Board board = Board::open("unix:" + path);
    const auto begin = Clock::now();
    prepare(board);
    expected = work(board);
    work_time = Clock::now() - begin;
  }

  // Anywhere from before the first answer to well after the first round of work.
  std::chrono::microseconds moment(int number) const {
    std::mt19937_64 random(static_cast<std::uint64_t>(number) + 1);
    const auto most = std::chrono::duration_cast<std::chrono::microseconds>(2 * work_time).count();
    return std::chrono::microseconds(random() % static_cast<std::uint64_t>(most));
  }

  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  Round expected;
  Clock::duration work_time{};
};

TEST_F(Kill, OfTheBoardAtRandomMomentsIsReportedAndTheApplicationGoesOn) {
  std::optional<BoardProcess> process(std::in_place, arguments(path));
  process->read_line();
  Clock::duration slowest{};
  for (int i = 0; i < kMoments; ++i) {
    Board board = Board::open("unix:" + path, patient());
    std::atomic<Clock::rep> killed{0};
    std::jthread killer([&, wait = moment(i)] {
      std::this_thread::sleep_for(wait);
      killed = Clock::now().time_since_epoch().count();
      process->send_signal(SIGKILL);
    });
    EXPECT_THROW(
        {
          prepare(board);
          for (;;) work(board);
        },
        DeviceLost)
        << i;
    slowest = std::max(slowest, Clock::now().time_since_epoch() - Clock::duration(killed.load()));
    EXPECT_THROW(board.counters(), DeviceLost) << i;
    killer.join();
    EXPECT_EQ(process->exit_code(), 128 + SIGKILL);
    process.emplace(arguments(path));
    process->read_line();
    const Reopened reopened = board.reopen();
    EXPECT_FALSE(reopened.resumed) << i;
    if (!reopened.volume) prepare(board);  // killed before it was there
    const Round again = work(board);
    ASSERT_EQ(again.pictures, expected.pictures) << i;
    for (std::size_t batch = 0; batch < again.batches.size(); ++batch) {
      ASSERT_TRUE(again.batches[batch].rays == expected.batches[batch].rays) << i;
    }
  }
  RecordProperty("slowest_report_us",
                 std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(slowest).count()));
}

TEST_F(Kill, OfTheBoardLosesNoBatchThatWasSubmitted) {
  constexpr std::size_t kBatches = 40, kRays = 500;
  std::optional<BoardProcess> process(std::in_place, arguments(path));
  process->read_line();
  std::vector<std::vector<TracedRay>> sound(kBatches);
  Board board = Board::open("unix:" + path, patient());
  prepare(board);
  for (std::size_t i = 0; i < kBatches; ++i) sound[i] = board.receive(board.submit(good_rays(i * kRays, kRays))).rays;
  for (int round = 0; round < 20; ++round) {
    std::vector<Ticket> tickets;
    for (std::size_t i = 0; i < kBatches; ++i) tickets.push_back(board.submit(good_rays(i * kRays, kRays)));
    std::size_t received = 0;
    const auto receive_all = [&] {
      for (; received < kBatches; ++received)
        ASSERT_TRUE(board.receive(tickets[received]).rays == sound[received]) << received;
    };
    std::jthread killer([&, wait = moment(round) / 4] {
      std::this_thread::sleep_for(wait);
      process->send_signal(SIGKILL);
    });
    try {
      receive_all();
    } catch (const DeviceLost&) {
    }
    killer.join();
    EXPECT_EQ(process->exit_code(), 128 + SIGKILL);
    process.emplace(arguments(path));
    process->read_line();
    const Reopened reopened = board.reopen();
    EXPECT_FALSE(reopened.resumed);
    ASSERT_TRUE(reopened.volume);
    receive_all();
    EXPECT_THROW(board.receive(tickets[0]), BadArgument) << "received twice";
    ASSERT_EQ(board.counters().value("dsp.host_rays") % kRays, 0u);
  }
}

TEST_F(Kill, OfTheClientAtRandomMomentsFreesTheBoardForTheNext) {
  BoardProcess process(arguments(path));
  process.read_line();
  Clock::duration slowest{};
  for (int i = 0; i < kMoments; ++i) {
    BoardProcess victim({path}, -1, GICUBE_TESTS_DIR "/gicube-victim");
    ASSERT_EQ(victim.read_line(), "working") << victim.read_errors();
    std::this_thread::sleep_for(moment(i));
    victim.send_signal(SIGKILL);
    ASSERT_EQ(victim.exit_code(), 128 + SIGKILL) << victim.read_errors();
    const auto begin = Clock::now();
    Board board = Board::open("unix:" + path, patient());
    slowest = std::max(slowest, Clock::now() - begin);
    prepare(board);
    ASSERT_EQ(work(board), expected) << i;
  }
  RecordProperty("slowest_open_us",
                 std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(slowest).count()));
}

}  // namespace
}  // namespace gicube::system_test
