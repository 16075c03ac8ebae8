// Deadlines, back-pressure, cancelling, and rays in the caller's own memory.
#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

constexpr Picoseconds kSecond = 1'000'000'000'000;

TEST(Deadline, PassesWhenTheBatchIsStillUnderWayAndTheBatchArrivesLater) {
  Board board = box_board();
  const auto sent = front_rays(5000);
  const Picoseconds before = board.now();
  const Ticket ticket = board.submit(sent);
  const Picoseconds deadline = before + 1'000'000;  // 1 us: not even on the board
  EXPECT_THROWS(DeadlinePassed, fmt::format("the result did not come by {} ps of simulated time", deadline),
                board.receive(ticket, deadline));
  EXPECT_EQ(board.now(), deadline);
  const RayBatch batch = board.receive(ticket);
  EXPECT_EQ(batch.rays.size(), 5000u);
  EXPECT_GT(batch.completed, deadline);
}

TEST(Deadline, BetweenTheCommandsOfABatchLosesNoneOfThem) {
  Board board = box_board();
  const auto sent = front_rays(10'000);
  const RayBatch whole = board.receive(board.submit(sent));
  const Picoseconds begin = board.now();
  const Ticket ticket = board.submit(sent);
  EXPECT_THROW(board.receive(ticket, begin + 1'000'000'000), DeadlinePassed);
  EXPECT_THROW(board.receive(ticket, begin + 2'000'000'000), DeadlinePassed);
  EXPECT_EQ(board.receive(ticket, begin + kSecond).rays, whole.rays);
}

TEST(Deadline, DoesNotChangeWhenABatchArrives) {
  Board board = box_board(), other = box_board();
  const auto sent = front_rays(5000);
  const Ticket ticket = board.submit(sent), plain = other.submit(sent);
  EXPECT_THROW(board.receive(ticket, board.now() + 1'000'000), DeadlinePassed);
  EXPECT_EQ(board.receive(ticket).completed, other.receive(plain).completed);
}

TEST(Deadline, OfARenderingLeavesABoardThatGoesOn) {
  Board board = box_board();
  const View view = front_view(32);
  const Image picture = board.render(view);
  board.set_time_limit(1'000'000);
  const Picoseconds before = board.now();
  EXPECT_THROWS(DeadlinePassed, "the result did not come by ", board.render(view));
  EXPECT_LE(board.now(), before + 2'000'000);
  board.set_time_limit(0);
  EXPECT_EQ(board.render(view).pixels, picture.pixels);
}

TEST(BackPressure, WaitsInSimulatedTimeUntilRaysHaveComeBack) {
  Board board = box_board(0.1, {.max_rays = 8192});
  const auto sent = front_rays(4096);
  std::vector<Ticket> tickets;
  const Picoseconds before = board.now();
  tickets.push_back(board.submit(sent));
  tickets.push_back(board.submit(sent));
  EXPECT_EQ(board.now(), before);
  tickets.push_back(board.submit(sent));
  EXPECT_GT(board.now(), before);
  for (const Ticket ticket : tickets) EXPECT_EQ(board.receive(ticket).rays.size(), 4096u);
}

TEST(BackPressure, ThrowsIfItIsAskedToAndNothingIsSent) {
  Board board = box_board(0.1, {.max_rays = 8192, .back_pressure = BackPressure::kThrow});
  const auto sent = front_rays(4096);
  const Ticket first = board.submit(sent);
  board.submit(sent);
  const std::uint64_t under_way = board.counters().value("dsp.host_rays");
  EXPECT_THROWS(WouldBlock, "at most 8192 under way", board.submit(std::span(sent).first(1)));
  EXPECT_EQ(board.counters().value("dsp.host_rays"), under_way);
  board.receive(first);
  EXPECT_NO_THROW(board.submit(std::span(sent).first(1)));
  EXPECT_THROW(Board::open(kSmallBlocks, {.max_rays = 100}), BadArgument);
}

TEST(Cancel, TakesBackWhatTheDspHasNotBegun) {
  Board board = box_board();
  const auto sent = front_rays(4096);
  const Ticket first = board.submit(sent), second = board.submit(sent), third = board.submit(sent);
  EXPECT_TRUE(board.cancel(second));
  const RayBatch cancelled = board.receive(second);
  EXPECT_TRUE(cancelled.cancelled);
  EXPECT_TRUE(cancelled.rays.empty());
  EXPECT_FALSE(board.receive(first).cancelled);
  const RayBatch last = board.receive(third);
  EXPECT_EQ(last.rays.size(), 4096u);
  EXPECT_THROW(board.cancel(second), BadArgument);
}

TEST(Cancel, SavesTheDspsAndTheBussTime) {
  Board board = box_board(), other = box_board();
  const auto sent = front_rays(4096);
  const auto last_of_three = [&](Board& on, bool cancels) {
    const Picoseconds begin = on.now();
    on.submit(sent);
    const Ticket second = on.submit(sent), third = on.submit(sent);
    if (cancels) on.cancel(second);
    return on.receive(third).completed - begin;
  };
  const Picoseconds whole = last_of_three(other, false), less = last_of_three(board, true);
  EXPECT_LT(less, whole);
  // 4096 rays of 32 bytes up PCI are about 1 ms.
  EXPECT_GT(whole - less, 650'000'000u);
}

TEST(Cancel, IsTooLateForWhatHasBegun) {
  Board board = box_board();
  const Ticket ticket = board.submit(front_rays(100));
  board.host_compute(kSecond);
  EXPECT_FALSE(board.cancel(ticket));
  EXPECT_EQ(board.receive(ticket).rays.size(), 100u);
  board.clear_irradiance(1);
  auto deposits = front_rays(10);
  for (HostRay& ray : deposits) ray.energy = 1;
  const Ticket spent = board.submit(deposits, {.type = RayType::kDeposit});
  EXPECT_THROW(board.cancel(spent), Unsupported);
  EXPECT_TRUE(board.receive(spent).lighting);
}

TEST(CallersMemory, RaysFromSeveralPlacesComeBackAsOneBatchIntoTheRoomThatIsGiven) {
  Board board = box_board();
  const auto sent = front_rays(9000);
  const std::array<std::span<const HostRay>, 4> parts{
      std::span(sent).first(1), std::span(sent).subspan(1, 5000), {}, std::span(sent).subspan(5001)};
  std::vector<TracedRay> room(9000);
  const Ticket ticket = board.submit(parts);
  EXPECT_THROW(board.receive(ticket, std::span(room).first(8999)), BadArgument);
  const BatchReport report = board.receive(ticket, room);
  EXPECT_EQ(report.ticket, ticket);
  EXPECT_EQ(board.now(), report.completed);
  EXPECT_EQ(room, board.receive(board.submit(sent)).rays);
}

}  // namespace
}  // namespace gicube
