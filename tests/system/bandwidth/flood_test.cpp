// Rays that the host makes and takes back flood PCI [P §3.6]: the bus is busy all the time, and a frame of 512^2 rays
// of 32 bytes each way comes at most 7.9 times a second. AGP 2x carries more than twice as many. Functional level.
#include <gtest/gtest.h>

#include "bus_form.h"
#include "ray_source.h"

namespace gicube::bandwidth {
namespace {

constexpr std::size_t kRays = 512 * 512;
constexpr std::size_t kBatch = 4096;
constexpr int kEdge = 2;

TEST(Flood, AFrameOfHostRaysTakesTheClosedFormOfTheBus) {
  const test::BoardSetup setup = test::BoardSetup::from_environment();
  const BusForm bus = bus_form(setup.bus);
  Board board = open_with_volume(setup, kEdge);
  const std::vector<HostRay> rays = rays_along_z(kRays, kEdge);

  const test::Window window(board);
  std::vector<Ticket> tickets;
  for (std::size_t i = 0; i < kRays; i += kBatch)
    tickets.push_back(board.submit(std::span(rays).subspan(i, kBatch), kEveryVoxel));
  for (const Ticket ticket : tickets) ASSERT_EQ(board.receive(ticket).rays.size(), kBatch);
  const test::Measured frame = window.end();

  // The first batch comes down and goes through the DSP before anything goes up.
  const double batch_dwords = kDwordsPerRay * kBatch;
  const double lead = bus.down_ps(batch_dwords, bus.down) + kDspPsPerRay * kBatch;
  EXPECT_TRUE(time_is(frame, flooded_ps(bus, kDwordsPerRay * kRays, lead), 0.01));
  EXPECT_TRUE(counter_is(frame, "bus.up.bytes", 32.0 * kRays));
  EXPECT_TRUE(counter_is(frame, "bus.down.bytes", 32.0 * kRays, 0.001));  // and the commands' headers
  const double busy = frame.share("bus.down.busy_ps") + frame.share("bus.up.busy_ps");
  EXPECT_TRUE(test::near("share of the time in which the bus is busy", busy, 1, 0.01));

  const double rate = 1e12 / static_cast<double>(frame.time);
  RecordProperty("frames_per_second", std::to_string(rate));
  if (setup.bus == "pci33") {
    EXPECT_LE(rate, 132e6 / (2 * 32.0 * kRays)) << "more than the peak of PCI";  // 7.87 Hz
  } else if (setup.bus != "agp1x") {
    EXPECT_GT(rate, 2 * 7.87);
  }
}

}  // namespace
}  // namespace gicube::bandwidth
