// Position stepping: a ray adds one rounded step to itself over and over, and drifts from its line.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "stability.h"

namespace gicube::stability {
namespace {

constexpr int kLong = 512, kAcross = 32, kWall = 500;

// Air, and at the far end a wall.
void load_wall(Board& board) {
  std::vector<std::byte> samples(std::size_t{kLong} * kAcross * kAcross);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = i % kLong >= kWall ? std::byte{200} : std::byte{0};
  board.load_volume({.samples = samples, .dims = {kLong, kAcross, kAcross}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{100, 0}, {100, 1}}});
}

std::int64_t step_word(double component, double step) {
  return static_cast<std::int64_t>(
      std::floor(static_cast<double>(std::lround(component * kDirectionOne)) * step + 0.5));
}

TEST(StabilityOfPositionStepping, LongRaysDriftWithinTheBoundThatHardwareStates) {
  Board board = open_board("emu:?set=asic.max_volume_voxels=512");
  load_wall(board);
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> slope(-0.025, 0.025);
  for (const double step : {1.0 / 64, 0.5, 1.0, 4.0}) {
    std::vector<HostRay> rays;
    for (std::uint32_t i = 0; i < 1500; ++i)
      rays.push_back({.id = i, .position = {1, 16, 16}, .direction = {1, slope(engine), slope(engine)}});
    const RayBatch hits = board.receive(board.submit(rays, {.type = RayType::kFirstHit, .opacity = 0.5, .step = step}));
    double worst = 0, worst_share = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const TracedRay& hit = hits.rays.at(i);
      ASSERT_GE(hit.opacity, 0.5) << i;
      const Vec3 unit = (1 / length(rays[i].direction)) * rays[i].direction;
      const double steps = (hit.position.x - 1) * kPositionOne / static_cast<double>(step_word(unit.x, step));
      ASSERT_EQ(steps, std::round(steps)) << i;
      const double path = steps * step;
      const Vec3 drift = hit.position - (rays[i].position + path * unit);
      const double most = std::max({std::abs(drift.x), std::abs(drift.y), std::abs(drift.z)});
      const double bound = path * (1 + 1 / step) / 32'768;
      ASSERT_LE(most, bound) << i << " step " << step;
      worst = std::max(worst, most);
      worst_share = std::max(worst_share, most / bound);
    }
    char name[64];
    std::snprintf(name, sizeof name, "drift_over_500_voxels_at_step_%g", step);
    record(name, worst);
    EXPECT_GT(worst_share, 0.45) << "the bound says nothing at step " << step;
  }
}

// What it costs: the way to the wall, by a ray's own count of samples, is wrong by at most the drift.
TEST(StabilityOfPositionStepping, HalfVoxelStepsPutAWallInItsPlace) {
  Board board = open_board("emu:?set=asic.max_volume_voxels=512");
  load_wall(board);
  std::vector<HostRay> rays;
  for (std::uint32_t i = 0; i < 200; ++i)
    rays.push_back({.id = i, .position = {1, 16, 16}, .direction = {1, (i - 100.0) / 4000, 0.011}});
  const RayBatch hits = board.receive(board.submit(rays, {.type = RayType::kFirstHit, .opacity = 0.5, .step = 0.5}));
  for (const TracedRay& hit : hits.rays) {
    EXPECT_GE(hit.position.x, kWall - 0.5);  // there the interpolated value is 100
    EXPECT_LE(hit.position.x, kWall + 0.01);
  }
}

}  // namespace
}  // namespace gicube::stability
