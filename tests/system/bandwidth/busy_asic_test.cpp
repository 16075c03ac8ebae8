// With an ASIC that has work to do, host rays flood PCI and not AGP [P §3.6]: on PCI they come at the rate of the bus,
// on AGP at the rate at which the processor takes samples. Cycle level, where each sample costs a core cycle.
#include <gtest/gtest.h>

#include "bus_form.h"
#include "ray_source.h"

namespace gicube::bandwidth {
namespace {

constexpr std::size_t kRays = 16 * 4096;
constexpr std::size_t kBatch = 4096;
constexpr int kEdge = 32;                // one block, one queue
constexpr double kSamples = kEdge;       // a ray, one at each voxel
constexpr double kCoreCyclePs = 10'000;  // 100 MHz
constexpr double kWayRound = 35;         // cycles of a lone ray through the pipeline [H307]

TEST(BusyAsic, HostRaysAreBoundByTheBusOnPciAndByTheProcessorOnAgp) {
  const test::BoardSetup setup = test::BoardSetup::from_environment();
  const BusForm bus = bus_form(setup.bus);
  Board board = open_with_volume(setup, kEdge);
  const std::vector<HostRay> rays = rays_along_z(kRays, kEdge);

  const test::Window window(board);
  std::vector<Ticket> tickets;
  for (std::size_t i = 0; i < kRays; i += kBatch)
    tickets.push_back(board.submit(std::span(rays).subspan(i, kBatch), kEveryVoxel));
  for (const Ticket ticket : tickets) ASSERT_EQ(board.receive(ticket).rays.size(), kBatch);
  const test::Measured stream = window.end();

  // Down 994 us, samples 1311 us, up 994 us a batch on PCI, but 2063 us for both ways when they take turns;
  // 261, 1311, 497 us on AGP 2x.
  const double batch_dwords = kDwordsPerRay * kBatch;
  const double down = bus.down_ps(batch_dwords, bus.down), up = bus.up_ps(batch_dwords, bus.up);
  // A sample a cycle; the last ray of a batch comes round alone.
  const double asic = (kBatch + kWayRound) * kSamples * kCoreCyclePs;
  const double busy = stream.share("bus.down.busy_ps") + stream.share("bus.up.busy_ps");
  if (setup.bus == "pci33") {
    EXPECT_TRUE(time_is(stream, flooded_ps(bus, kDwordsPerRay * kRays, down + asic), 0.01));
    EXPECT_GT(busy, 0.99);
  } else {
    // The first batch comes down, the ASIC goes on without a pause, the last batch goes up.
    EXPECT_TRUE(time_is(stream, down + asic * kRays / kBatch + up, 0.01));
    EXPECT_LT(busy, 0.7);
  }
  EXPECT_TRUE(counter_is(stream, "processor.samples", kSamples * kRays));
}

}  // namespace
}  // namespace gicube::bandwidth
