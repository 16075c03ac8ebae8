// Sending rays, tracing them and taking them back go on at the same time if the application lets them, and so does its
// own work; one after the other they take the sum. Cycle level, AGP 2x and PCI.
#include <gtest/gtest.h>

#include "bus_form.h"
#include "ray_source.h"

namespace gicube::bandwidth {
namespace {

constexpr std::size_t kBatches = 12;
constexpr std::size_t kBatch = 4096;
constexpr int kEdge = 32;
constexpr double kCoreCyclePs = 10'000;
constexpr double kWayRound = 35;  // cycles of a lone ray through the pipeline [H307]

struct Stages {
  double down, asic, up;  // of one batch that is alone, picoseconds

  explicit Stages(const BusForm& bus)
      : down(bus.down_ps(kDwordsPerRay * kBatch, bus.down)),
        asic((kBatch + kWayRound) * kEdge * kCoreCyclePs),  // the last ray comes round alone
        up(bus.up_ps(kDwordsPerRay * kBatch, bus.up)) {}
};

// When all stages overlap, the narrowest is never idle: the ASIC, or the bus that both directions share.
double overlapped_ps(const BusForm& bus, const Stages& stage) {
  const double by_asic = stage.down + kBatches * stage.asic + stage.up;
  return std::max(by_asic, flooded_ps(bus, kDwordsPerRay * kBatch * kBatches, stage.down + stage.asic));
}

class Overlap : public testing::Test {
 protected:
  const test::BoardSetup setup_ = test::BoardSetup::from_environment();
  const BusForm bus_ = bus_form(setup_.bus);
  const Stages stage_{bus_};
  Board board_ = open_with_volume(setup_, kEdge);
  const std::vector<HostRay> rays_ = rays_along_z(kBatch, kEdge);
};

TEST_F(Overlap, WaitingForEachBatchCostsTheSumOfItsStages) {
  const test::Window window(board_);
  for (std::size_t i = 0; i < kBatches; ++i) board_.receive(board_.submit(rays_, kEveryVoxel));
  EXPECT_TRUE(time_is(window.end(), kBatches * (stage_.down + stage_.asic + stage_.up), 0.01));
}

TEST_F(Overlap, BatchesInFlightCostTheNarrowestStage) {
  const test::Window window(board_);
  std::vector<Ticket> tickets;
  for (std::size_t i = 0; i < kBatches; ++i) tickets.push_back(board_.submit(rays_, kEveryVoxel));
  for (const Ticket ticket : tickets) board_.receive(ticket);
  EXPECT_TRUE(time_is(window.end(), overlapped_ps(bus_, stage_), 0.01));
}

TEST_F(Overlap, WorkOfTheHostThatTakesNoLongerIsFree) {
  const test::Window window(board_);
  std::vector<Ticket> tickets;
  for (std::size_t i = 0; i < kBatches; ++i) tickets.push_back(board_.submit(rays_, kEveryVoxel));
  board_.host_compute(static_cast<Picoseconds>(0.9 * overlapped_ps(bus_, stage_)));
  for (const Ticket ticket : tickets) board_.receive(ticket);
  EXPECT_TRUE(time_is(window.end(), overlapped_ps(bus_, stage_), 0.01));
}

// Two batches in flight, and the host makes the next one while the board has the other: the host is the narrowest
// stage.
TEST_F(Overlap, AHostThatIsSlowerThanTheBoardHidesTheBoard) {
  const double making = 1.5 * (stage_.down + stage_.asic + stage_.up);
  const test::Window window(board_);
  Ticket last = board_.submit(rays_, kEveryVoxel);
  for (std::size_t i = 1; i < kBatches; ++i) {
    board_.host_compute(static_cast<Picoseconds>(making));
    const Ticket next = board_.submit(rays_, kEveryVoxel);
    board_.receive(last);
    last = next;
  }
  board_.receive(last);
  EXPECT_TRUE(time_is(window.end(), (kBatches - 1) * making + stage_.down + stage_.asic + stage_.up, 0.01));
}

}  // namespace
}  // namespace gicube::bandwidth
