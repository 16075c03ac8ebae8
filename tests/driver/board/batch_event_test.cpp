// Batches that an event loop waits for, and their handles: what happens with several, without a board, and after the
// end.
#include <poll.h>
#include <signal.h>
#include <sys/epoll.h>

#include <future>

#include "test.h"
#include "test_board.h"
#include "transport/fd.h"

namespace gicube {
namespace {

bool readable(const Fd& descriptor) {
  pollfd waits{descriptor.get(), POLLIN, 0};
  return ::poll(&waits, 1, 0) == 1;
}
void wait_for(const Fd& descriptor) {
  pollfd waits{descriptor.get(), POLLIN, 0};
  ASSERT_EQ(::poll(&waits, 1, -1), 1);
}

TEST(Descriptor, IsReadableOnceTheBoardHasDoneTheWorkAndStaysSo) {
  auto [board, id] = stopped_board();
  const Ticket ticket = board.submit(front_rays(5000));
  const Fd descriptor(board.descriptor(ticket)), another(board.descriptor(ticket));
  EXPECT_FALSE(readable(descriptor));
  ::kill(id, SIGCONT);
  wait_for(descriptor);
  EXPECT_TRUE(readable(descriptor));
  EXPECT_TRUE(readable(another));
  EXPECT_EQ(board.receive(ticket).rays.size(), 5000u);
  EXPECT_TRUE(readable(descriptor));
  EXPECT_THROW(board.descriptor(ticket), BadArgument);
}

TEST(Descriptor, OfABatchWithoutRaysIsReadableToo) {
  Board board = box_board();
  wait_for(Fd(board.descriptor(board.submit(std::span<const HostRay>{}))));
}

TEST(Descriptor, OfEachOfSeveralBatchesCanBeWaitedForInAnyOrder) {
  Board board = box_board(), plain = box_board();
  const auto sent = front_rays(20'000);
  constexpr std::size_t kBatches = 6;
  std::vector<Ticket> tickets;
  std::vector<Fd> descriptors;
  const Fd loop(::epoll_create1(EPOLL_CLOEXEC));
  for (std::uint32_t i = 0; i < kBatches; ++i) {
    tickets.push_back(board.submit(std::span(sent).first(3000 * (i + 1))));
    descriptors.emplace_back(board.descriptor(tickets[i]));
    epoll_event waits{.events = EPOLLIN | EPOLLONESHOT, .data = {.u32 = i}};
    ASSERT_EQ(::epoll_ctl(loop.get(), EPOLL_CTL_ADD, descriptors[i].get(), &waits), 0);
  }
  wait_for(descriptors[4]);
  EXPECT_EQ(board.receive(tickets[4]).rays.size(), 15'000u);
  std::vector<std::uint32_t> arrived;
  while (arrived.size() < kBatches) {
    epoll_event event{};
    ASSERT_EQ(::epoll_wait(loop.get(), &event, 1, -1), 1);
    const std::uint32_t i = event.data.u32;
    arrived.push_back(i);
    if (i == 4) continue;
    const auto part = std::span(sent).first(3000 * (i + 1));
    EXPECT_EQ(board.receive(tickets[i]).rays, plain.receive(plain.submit(part)).rays);
  }
  EXPECT_THAT(arrived, testing::UnorderedElementsAre(0, 1, 2, 3, 4, 5));
}

TEST(Descriptor, MovesNoSimulatedTime) {
  const auto run = [](bool asks) {
    Board board = box_board();
    const auto sent = front_rays(9000);
    std::vector<Picoseconds> times;
    std::vector<Ticket> tickets;
    std::vector<Fd> descriptors;
    for (int i = 0; i < 4; ++i) {
      tickets.push_back(board.submit(sent));
      if (asks) descriptors.emplace_back(board.descriptor(tickets.back()));
      times.push_back(board.now());
      board.host_compute(100'000'000);
    }
    if (asks) wait_for(descriptors[3]);
    times.push_back(board.now());
    for (const RayBatch& batch : board.poll()) times.push_back(batch.completed);
    for (const int i : {3, 2, 1, 0}) {
      try {
        times.push_back(board.receive(tickets[static_cast<std::size_t>(i)]).completed);
      } catch (const BadArgument&) {
        times.push_back(0);  // poll() has given it
      }
      times.push_back(board.now());
    }
    return times;
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(Descriptor, IsReadableWhenTheBoardIsLostAndTheResultSaysSo) {
  auto [board, id] = stopped_board();
  const auto sent = front_rays(100);
  const Ticket first = board.submit(sent), second = board.submit(sent);
  const Fd of_first(board.descriptor(first)), of_second(board.descriptor(second));
  EXPECT_FALSE(readable(of_first));
  ::kill(id, SIGKILL);
  wait_for(of_second);
  wait_for(of_first);
  EXPECT_THROW(board.receive(first), DeviceLost);
  EXPECT_THROW(board.descriptor(first), DeviceLost);
}

TEST(Descriptor, IsReadableWhenTheWatchdogEndsTheWait) {
  auto [board, id] = stopped_board({.watchdog = std::chrono::seconds(2)});  // a busy machine opens a board in less
  const Ticket ticket = board.submit(front_rays(100));
  wait_for(Fd(board.descriptor(ticket)));
  try {
    board.receive(ticket);
    ADD_FAILURE() << "a board that does nothing has answered";
  } catch (const DeviceLost& error) {
    EXPECT_EQ(error.cause(), Loss::kTimedOut);
  }
  ::kill(id, SIGCONT);
}

TEST(Descriptor, OfABatchThatIsSentAgainIsANewOne) {
  auto [board, id] = stopped_board({.keep_volume = true});
  const Ticket ticket = board.submit(front_rays(5000));
  const Fd before(board.descriptor(ticket));
  ::kill(id, SIGKILL);
  wait_for(before);
  EXPECT_THROW(board.receive(ticket), DeviceLost);
  EXPECT_FALSE(board.reopen().resumed);
  wait_for(Fd(board.descriptor(ticket)));
  EXPECT_EQ(board.receive(ticket).rays.size(), 5000u);
}

TEST(Descriptor, IsReadableOnceTheBoardIsClosed) {
  Fd descriptor;
  std::thread other;
  {
    auto [board, id] = stopped_board();
    descriptor = Fd(board.descriptor(board.submit(front_rays(5000))));
    EXPECT_FALSE(readable(descriptor));
    other = std::thread([&descriptor, id = id] {
      wait_for(descriptor);
      ::kill(id, SIGKILL);  // or closing would wait for the process to end
    });
  }
  EXPECT_TRUE(readable(descriptor));
  other.join();
}

TEST(Descriptor, OfAnUnknownTicketIsRefused) {
  Board board = box_board();
  EXPECT_THROW(board.descriptor({77}), BadArgument);
}

TEST(PendingBatch, IsTheBatchThatReceiveWouldGive) {
  Board board = box_board(), plain = box_board();
  const auto sent = front_rays(5000);
  auto first = board.rays().start(sent), second = board.rays().start(sent);
  const Ticket a = plain.submit(sent), b = plain.submit(sent);
  EXPECT_TRUE(second.wait(std::chrono::hours(1)));
  EXPECT_EQ(board.now(), plain.now()) << "waiting takes no simulated time";
  const RayBatch batch = second.get();
  const RayBatch expected = plain.receive(b);
  EXPECT_EQ(batch.rays, expected.rays);
  EXPECT_EQ(batch.completed, expected.completed);
  EXPECT_EQ(board.now(), plain.now());
  EXPECT_EQ(first.get().completed, plain.receive(a).completed);
  EXPECT_THROW(first.get(), BadArgument);
}

TEST(PendingBatch, HasASimulatedDeadlineAndComesAfterIt) {
  Board board = box_board();
  auto batch = board.rays().start(front_rays(5000));
  EXPECT_THROW(batch.get(board.now() + 1), DeadlinePassed);
  EXPECT_EQ(batch.get().rays.size(), 5000u);
}

TEST(PendingBatch, IsNotReadyBeforeTheBoardHasDoneTheWork) {
  auto [board, id] = stopped_board();
  auto batch = board.rays().start(front_rays(5000));
  EXPECT_FALSE(batch.ready());
  EXPECT_FALSE(batch.wait(std::chrono::milliseconds(20)));
  const Fd descriptor(batch.descriptor());
  EXPECT_FALSE(readable(descriptor));
  ::kill(id, SIGCONT);
  wait_for(descriptor);
  EXPECT_TRUE(batch.ready());
}

TEST(PendingBatch, ComesBackCancelled) {
  Board board = box_board();
  auto first = board.rays().start(front_rays(30'000)), second = board.rays().start(front_rays(5000));
  EXPECT_TRUE(second.cancel());
  EXPECT_TRUE(second.get().cancelled);
  EXPECT_FALSE(first.get().cancelled);
}

TEST(PendingBatch, OutlivesItsBoardAndSaysSo) {
  std::optional<Pending<RayBatch>> batch;
  {
    Board board = box_board();
    batch = board.rays().start(front_rays(10));
  }
  try {
    batch->get();
    ADD_FAILURE() << "a board that is closed has answered";
  } catch (const DeviceLost& error) {
    EXPECT_EQ(error.cause(), Loss::kClosed);
  }
}

TEST(PendingBatch, ThatIsWaitedForThrowsWhenItsBoardIsClosedOrReplaced) {
  for (const bool replaced : {false, true}) {
    BoardProcess process = stopped_board();
    auto board = std::make_unique<Board>(std::move(process.board));
    auto batch = board->rays().start(front_rays(5000));
    std::promise<void> begins;
    std::thread waits([&] {
      begins.set_value();
      EXPECT_THROW(batch.get(), DeviceLost);
    });
    begins.get_future().wait();
    if (replaced) {
      *board = box_board();
      EXPECT_NO_THROW(board->counters());
    } else {
      board.reset();
    }
    ::kill(process.id, SIGKILL);  // or the last owner would wait for the process to end
    waits.join();
  }
}

}  // namespace
}  // namespace gicube
