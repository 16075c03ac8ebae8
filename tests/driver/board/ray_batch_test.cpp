#include "test.h"
#include "test_board.h"

namespace gicube {
namespace {

class RayBatches : public ::testing::Test {
 protected:
  void SetUp() override { load_box(board_); }

  // Rays along +z through a square of the front face.
  static std::vector<HostRay> rays(std::uint32_t count) {
    std::vector<HostRay> list;
    for (std::uint32_t i = 0; i < count; ++i) {
      list.push_back({.id = 7 * i, .position = {i % 31 + 0.25, i / 31 % 31 + 0.25, 0}, .direction = {0, 0, 3}});
    }
    return list;
  }

  Board board_ = Board::open("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64");
};

TEST_F(RayBatches, ComeBackInTheirOrderWithTheirIdsAndIntegrals) {
  const RayBatch batch = board_.receive(board_.submit(rays(961)));
  ASSERT_EQ(batch.rays.size(), 961u);
  for (std::uint32_t i = 0; i < 961; ++i) EXPECT_EQ(batch.rays[i].id, 7 * i);
  EXPECT_EQ(batch.rays[0].opacity, 0);
  EXPECT_DOUBLE_EQ(batch.rays[0].position.z, 31);
  EXPECT_NEAR(batch.rays[15 * 31 + 15].opacity, 0.81, 0.02);  // 1 - 0.9^16
}

TEST_F(RayBatches, MoreThanOneCommandHoldsComesBackAsOneBatch) {
  const auto sent = rays(10'000);
  const RayBatch batch = board_.receive(board_.submit(sent));
  ASSERT_EQ(batch.rays.size(), sent.size());
  for (std::size_t i = 0; i < sent.size(); ++i) ASSERT_EQ(batch.rays[i].id, sent[i].id);
  EXPECT_EQ(batch.rays[9999].opacity, board_.receive(board_.submit(std::span(&sent[9999], 1))).rays[0].opacity);
}

TEST_F(RayBatches, SubmittingDoesNotMoveTheSimulatedClockAndReceivingDoes) {
  board_.receive(board_.submit(rays(1)));
  const Picoseconds before = board_.now();
  const Ticket ticket = board_.submit(rays(5000));
  EXPECT_EQ(board_.now(), before);
  const RayBatch batch = board_.receive(ticket);
  EXPECT_GT(batch.completed, before);
  EXPECT_EQ(board_.now(), batch.completed);
}

TEST_F(RayBatches, HostWorkOverlapsWithTheBoards) {
  const Ticket ticket = board_.submit(rays(100));
  board_.host_compute(1'000'000'000'000);
  const Picoseconds worked = board_.now();
  const RayBatch batch = board_.receive(ticket);
  EXPECT_LT(batch.completed, worked);
  EXPECT_LE(board_.now(), worked + 1'000'000);
}

TEST_F(RayBatches, MayBeReceivedInAnyOrderAndOnlyOnce) {
  const Ticket first = board_.submit(rays(10));
  const Ticket second = board_.submit(rays(20));
  EXPECT_EQ(board_.receive(second).rays.size(), 20u);
  EXPECT_EQ(board_.receive(first).rays.size(), 10u);
  EXPECT_THROW(board_.receive(first), BadArgument);
  EXPECT_THROW(board_.receive({12345}), BadArgument);
}

TEST_F(RayBatches, PollingGivesWhatHasArrivedInTheOrderOfArrival) {
  const Ticket first = board_.submit(rays(10));
  const Ticket second = board_.submit(rays(20));
  EXPECT_TRUE(board_.poll().empty());  // no simulated time has passed
  board_.host_compute(1'000'000'000'000);
  const auto arrived = board_.poll();
  ASSERT_EQ(arrived.size(), 2u);
  EXPECT_EQ(arrived[0].ticket, first);
  EXPECT_EQ(arrived[1].ticket, second);
  EXPECT_LT(arrived[0].completed, arrived[1].completed);
  EXPECT_TRUE(board_.poll().empty());
  EXPECT_THROW(board_.receive(first), BadArgument);
}

TEST_F(RayBatches, AnEmptyBatchIsDoneAtOnce) {
  const Ticket ticket = board_.submit(std::span<const HostRay>{});
  const Picoseconds before = board_.now();
  EXPECT_TRUE(board_.receive(ticket).rays.empty());
  EXPECT_EQ(board_.now(), before);
}

TEST_F(RayBatches, ABadRayIsNamedAndNothingIsSent) {
  auto list = rays(3);
  list[2].position.x = 99;
  const Counters before = board_.counters();
  EXPECT_THROWS(BadArgument, "rays[2].position.x", board_.submit(list));
  EXPECT_EQ((board_.counters() - before).value("dsp.host_rays"), 0u);
}

TEST_F(RayBatches, AreSampledAsTheirRequestSays) {
  View view = front_view(32);
  view.cut_planes = {{{0, 0, -1}, -15.5}};
  const RayBatch half = board_.receive(board_.submit(rays(961), {.sampling = sampling_of(view)}));
  EXPECT_NEAR(half.rays[15 * 31 + 15].opacity, 0.57, 0.03);  // 1 - 0.9^8
}

}  // namespace
}  // namespace gicube
