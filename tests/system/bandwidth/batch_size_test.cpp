// Many small batches against few big ones: what each ray costs, waited for one by one and in a stream. Functional
// level.
#include <gtest/gtest.h>

#include "bus_form.h"
#include "gicube/wire/command.h"
#include "ray_source.h"

namespace gicube::bandwidth {
namespace {

constexpr int kEdge = 2;
constexpr double kHeaderDwords = wire::kTraceHeaderBytes / 4.0;  // of each command, before its rays

// One by one: a batch of n rays comes down with its header, passes the DSP, goes up, and nothing else happens
// meanwhile.
double one_by_one_ps(const BusForm& bus, double n) {
  const double dwords = kDwordsPerRay * n;
  return bus.down_ps(dwords + kHeaderDwords, bus.down) + kDspPsPerBatch + kDspPsPerRay * n + bus.up_ps(dwords, bus.up);
}

// In a stream the bus is the narrowest stage: each batch costs it its bursts down and its bursts up, which take turns.
double streamed_ps(const BusForm& bus, double n) {
  const double dwords = kDwordsPerRay * n;
  return bus.down_ps(dwords + kHeaderDwords, bus.down_shared) + bus.up_ps(dwords, bus.up_shared);
}

class BatchSize : public testing::TestWithParam<std::size_t> {
 protected:
  std::size_t batch() const { return GetParam(); }
  std::size_t batches() const { return std::clamp<std::size_t>(131'072 / batch(), 64, 4096); }

  const test::BoardSetup setup_ = test::BoardSetup::from_environment();
  const BusForm bus_ = bus_form(setup_.bus);
  Board board_ = open_with_volume(setup_, kEdge);
  const std::vector<HostRay> rays_ = rays_along_z(batch(), kEdge);
};

TEST_P(BatchSize, OneByOneEachBatchCostsItsWayDownTheDspAndItsWayUp) {
  const test::Window window(board_);
  for (std::size_t i = 0; i < batches(); ++i) board_.receive(board_.submit(rays_, kEveryVoxel));
  const auto count = static_cast<double>(batches()), n = static_cast<double>(batch());
  const test::Measured measured = window.end();
  EXPECT_TRUE(time_is(measured, count * one_by_one_ps(bus_, n), 0.01));
  EXPECT_TRUE(counter_is(measured, "bus.down.bytes", count * (4 * kHeaderDwords + 32 * n)));
}

TEST_P(BatchSize, InAStreamEachBatchCostsTheBusItsBurstsDownAndUp) {
  const test::Window window(board_);
  std::vector<Ticket> tickets;
  for (std::size_t i = 0; i < batches(); ++i) tickets.push_back(board_.submit(rays_, kEveryVoxel));
  for (const Ticket ticket : tickets) board_.receive(ticket);
  const auto count = static_cast<double>(batches()), n = static_cast<double>(batch());
  const double per_batch = streamed_ps(bus_, n);
  // Before the first turn and after the last, one direction has the bus for itself: as long as the batch that leads.
  const double ends = one_by_one_ps(bus_, n) - streamed_ps(bus_, n);
  const test::Measured measured = window.end();
  EXPECT_TRUE(time_is(measured, count * per_batch + ends, 0.01));
  RecordProperty("rays_per_ms", std::to_string(count * n / to_ms(measured.time)));
}

INSTANTIATE_TEST_SUITE_P(Rays, BatchSize, testing::Values(1, 4, 16, 64, 256, 4096),
                         [](const auto& size) { return std::to_string(size.param); });

}  // namespace
}  // namespace gicube::bandwidth
