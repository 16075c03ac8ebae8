// Hostile and broken clients beside a good one: it must not notice them.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>

#include "board_process.h"
#include "good_client.h"
#include "hostile_client.h"
#include "temporary_directory.h"

namespace gicube::system_test {
namespace {

constexpr int kClients = 24;

// 24 threads, each a client that misbehaves again and again in every way.
class Siege {
 public:
  explicit Siege(const std::string& path) {
    for (int i = 0; i < kClients; ++i) {
      threads_.emplace_back([this, path, i](std::stop_token stop) {
        for (std::uint64_t round = 0; !stop.stop_requested(); ++round) {
          const int way = static_cast<int>((static_cast<std::uint64_t>(i) + round) % kHostileWays);
          if (misbehave(path, way, round * kClients + static_cast<std::uint64_t>(i)))
            ++tries_[static_cast<std::size_t>(way)];
        }
      });
    }
  }
  void wait_for(int tries_of_each_way) const {
    for (const auto& tries : tries_) {
      while (tries < tries_of_each_way) std::this_thread::yield();
    }
  }
  int tries() const {
    int all = 0;
    for (const auto& tries : tries_) all += tries;
    return all;
  }

 private:
  std::array<std::atomic<int>, kHostileWays> tries_{};
  std::vector<std::jthread> threads_;  // last: they end before what they count in
};

TEST(HostileClients, AGoodOneGetsTheSameBitsAtTheSameTimesBeside24OfThem) {
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  std::vector<std::string> arguments = small_board();
  arguments.insert(arguments.end(), {"--listen", "unix:" + path});
  BoardProcess process(arguments);
  process.read_line();

  // The second round writes fewer registers: it knows what they hold.
  Round first, second;
  {
    Board board = Board::open("unix:" + path);
    prepare(board);
    first = work(board);
    second = work(board);
  }
  Board board = Board::open("unix:" + path);
  {
    const Siege siege(path);
    siege.wait_for(1);
    prepare(board);
    ASSERT_EQ(work(board), first);
    ASSERT_EQ(work(board), second);
    siege.wait_for(10);
    for (int round = 0; round < 20; ++round) {
      const Round again = work(board);
      ASSERT_EQ(again.pictures, second.pictures);
      ASSERT_EQ(again.end - again.begin, second.end - second.begin);
    }
    RecordProperty("hostile_connections", siege.tries());
  }
  // And it goes on when they have gone.
  EXPECT_EQ(work(board).pictures, second.pictures);
}

}  // namespace
}  // namespace gicube::system_test
