// Hostile and broken clients beside a good one: it must not notice them.
#include <sys/resource.h>
#include <sys/stat.h>

#include <iostream>

#include "board_process.h"
#include "good_client.h"
#include "hostile_caller.h"
#include "hostile_client.h"
#include "sanitizers.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::system_test {
namespace {

using reference::RawClient;

// Threads, each of which misbehaves again and again in every way. They leave the processor to others: what a siege
// costs a good client is what it costs its board, not that both share one machine here.
class Siege {
 public:
  using Misbehave = std::function<bool(int way, std::uint64_t seed)>;  // false: it does not count

  Siege(int clients, int ways, const Misbehave& misbehave) : tries_(static_cast<std::size_t>(ways)) {
    for (int i = 0; i < clients; ++i) {
      threads_.emplace_back([this, misbehave, clients, ways, i](const std::stop_token& stop) {
        ::setpriority(PRIO_PROCESS, 0, 19);
        for (std::uint64_t round = 0; !stop.stop_requested(); ++round) {
          const int way = static_cast<int>((static_cast<std::uint64_t>(i) + round) % static_cast<std::uint64_t>(ways));
          const std::uint64_t seed = round * static_cast<std::uint64_t>(clients) + static_cast<std::uint64_t>(i);
          if (misbehave(way, seed)) ++tries_[static_cast<std::size_t>(way)];
        }
      });
    }
  }
  void wait_for(int tries_of_each_way) const {
    for (const auto& tries : tries_) {
      while (tries < tries_of_each_way) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  int tries() const {
    int all = 0;
    for (const auto& tries : tries_) all += tries;
    return all;
  }

 private:
  std::vector<std::atomic<int>> tries_;
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
    const Door door{[&path] { return RawClient::connect_unix(path); }};
    const Siege siege(24, kHostileWays, [&door](int way, std::uint64_t seed) { return misbehave(door, way, seed); });
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

std::uint16_t port_of(const std::string& line) {
  return static_cast<std::uint16_t>(std::stoi(line.substr(line.rfind(':') + 1)));
}

// Of 500 single rays, there and back: what a half and what all but one in a hundred take at most, in microseconds of
// this machine.
struct Latency {
  double half = 0, most = 0;
};
Latency latency(Board& board) {
  std::vector<double> all;
  for (std::uint64_t i = 0; i < 500; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    board.receive(board.submit(good_rays(i, 1)));
    all.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  std::ranges::sort(all);
  return {all[250], all[495]};
}

TEST(HostileClients, AtBothPlanesLeaveAGoodOneItsBitsAndTimesAndTheBoardItsMemory) {
  const reference::TemporaryDirectory folder;
  const std::string tokens = folder.file("tokens"), user = "token_of_the_good_client", reader = "token_of_who_may_read";
  std::ofstream(tokens) << "use " << user << "\nread " << reader << "\n";
  ASSERT_EQ(::chmod(tokens.c_str(), 0600), 0);
  std::vector<std::string> arguments = small_board();
  arguments.insert(arguments.end(), {"--listen", "tcp:127.0.0.1:0", "--management", "tcp:127.0.0.1:0", "--token-file",
                                     tokens, "--max-memory", "64", "--max-results", "16"});
  BoardProcess process(arguments);
  const std::uint16_t bus = port_of(process.read_line()), management = port_of(process.read_line());
  OpenOptions options;
  options.token_file = tokens;
  const std::string uri = "tcp:127.0.0.1:" + std::to_string(bus);
  Round first, second;
  {
    Board board = Board::open(uri, options);
    prepare(board);
    first = work(board);
    second = work(board);
  }
  Board board = Board::open(uri, options);
  prepare(board);
  ASSERT_EQ(work(board), first);
  ASSERT_EQ(work(board), second);
  const std::uint64_t memory = process.peak_memory();
  const Latency alone = latency(board);
  std::atomic<int> let_in = 0;
  Latency besieged;
  {
    const std::array doors{Door{[bus] { return RawClient::connect_tcp(bus); }},
                           Door{[bus] { return RawClient::connect_tcp(bus); }, user},
                           Door{[bus] { return RawClient::connect_tcp(bus); }, "token_that_nobody_was_given"}};
    const Siege at_bus(12, kHostileWays,
                       [&doors](int way, std::uint64_t seed) { return misbehave(doors[seed % 3], way, seed); });
    const Siege at_management(6, kHostileCalls, [&](int way, std::uint64_t seed) {
      let_in += misbehave_at_management(management, reader, way, seed);
      return true;
    });
    at_bus.wait_for(2);
    at_management.wait_for(2);
    besieged = latency(board);
    for (int round = 0; round < 10; ++round) {
      const Round again = work(board);
      ASSERT_EQ(again.pictures, second.pictures);
    }
    at_bus.wait_for(4);
    at_management.wait_for(4);
    RecordProperty("hostile_connections", at_bus.tries());
    RecordProperty("hostile_calls", at_management.tries());
  }
  EXPECT_EQ(let_in, 0);
  const std::uint64_t more = process.peak_memory() - memory;
  std::cout << "a ray there and back: half in " << alone.half << " us, 99% in " << alone.most << " us; besieged "
            << besieged.half << " and " << besieged.most << " us; " << (more >> 20) << " MiB more memory\n";
  if (!reference::kHasAddressSanitizer && !reference::kHasThreadSanitizer) {
    EXPECT_LT(more, std::uint64_t{64 + 16} << 20) << "the limits of volume and results";
  }
  const Round again = work(board);
  EXPECT_EQ(again.pictures, second.pictures);
}

}  // namespace
}  // namespace gicube::system_test
