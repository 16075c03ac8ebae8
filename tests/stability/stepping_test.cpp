// Position stepping: on the paper's datapath a ray adds one rounded step to itself over and over, and drifts from its
// line. The wide one carries what is below a unit along.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "gicube/wire/ray.h"
#include "stability.h"

namespace gicube::stability {
namespace {

constexpr int kLong = 500, kAcross = 32, kWall = 490;

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

TEST(StabilityOfPositionStepping, LongRaysDriftWithinTheBoundThatRayHStates) {
  Board board = Board::open("emu:?set=asic.max_volume_voxels=512");
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
      const double bound = wire::max_drift(path, static_cast<std::uint32_t>(step * kStepOne));
      ASSERT_LE(most, bound) << i << " step " << step;
      worst = std::max(worst, most);
      worst_share = std::max(worst_share, most / bound);
    }
    char name[64];
    std::snprintf(name, sizeof name, "drift_over_490_voxels_at_step_%g", step);
    record(name, worst);
    EXPECT_GT(worst_share, 0.45) << "the bound says nothing at step " << step;
  }
}

// 518 voxels from corner to corner: steps of 1/64 could drift by 1.03.
TEST(StabilityOfPositionStepping, StepsThatDriftByMoreThanAVoxelOverTheVolumeAreRefusedButOnTheWideDatapath) {
  const Dims dims{512, 60, 60};
  const std::vector<std::byte> samples(std::size_t{512} * 60 * 60);
  for (const bool wide : {false, true}) {
    Board board = Board::open(std::string("emu:?fidelity=functional&set=asic.max_volume_voxels=512") +
                              (wide ? "&set=asic.datapath=wide" : ""));
    board.load_volume({.samples = samples, .dims = dims});
    board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{100, 0}, {255, 1}}});
    const auto refused = [&](const auto& call, const std::string& field) {
      try {
        call();
        return false;
      } catch (const BadArgument& error) {
        EXPECT_EQ(error.what(),
                  field +
                      ": expected at least 0.017: in shorter steps positions drift by more than a voxel over "
                      "this volume (not with asic.datapath=wide), got 0.015625");
        return true;
      }
    };
    for (const double step : {1.0 / 64, 0.017}) {
      const bool expected = !wide && step < 0.016;
      View view;
      view.eye = {256, 30, -400};
      view.look_at = {256, 30, 30};
      view.width = view.height = 8;
      view.step = step;
      const HostRay ray{.id = 1, .position = {1, 1, 1}, .direction = {1, 0, 0}};
      EXPECT_EQ(refused([&] { board.render(view); }, "step"), expected);
      EXPECT_EQ(refused([&] { board.illuminate({}, {.step = step}); }, "step"), expected);
      EXPECT_EQ(refused([&] { board.receive(board.submit(std::span(&ray, 1), {.step = step})); }, "request.step"),
                expected);
      EXPECT_EQ(refused([&] { board.pair_factors({}, {}, {.step = step}); }, "request.step"), expected);
    }
  }
}

std::int64_t direction_word(double component) { return std::lround(component * kDirectionOne); }

TEST(StabilityOfPositionStepping, OnTheWideDatapathLongRaysStayWithinHalfAUnitOfTheirWords) {
  Board board = Board::open("emu:?set=asic.max_volume_voxels=512&set=asic.datapath=wide");
  load_wall(board);
  std::mt19937 engine(8);
  std::uniform_real_distribution<double> slope(-0.025, 0.025);
  for (const double step : {1.0 / 64, 0.3, 0.5, 4.0}) {
    const double step_word = std::round(step * kStepOne) / kStepOne;
    std::vector<HostRay> rays;
    for (std::uint32_t i = 0; i < 1500; ++i)
      rays.push_back({.id = i, .position = {1, 16, 16}, .direction = {1, slope(engine), slope(engine)}});
    for (const bool leap : {true, false}) {
      const RayBatch hits =
          board.receive(board.submit(rays, {.type = RayType::kFirstHit, .opacity = 0.5, .step = step, .leap = leap}));
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const TracedRay& hit = hits.rays.at(i);
        ASSERT_GE(hit.opacity, 0.5) << i;
        const Vec3 unit = (1 / length(rays[i].direction)) * rays[i].direction;
        const Vec3 words = (1 / kDirectionOne) * Vec3{double(direction_word(unit.x)), double(direction_word(unit.y)),
                                                      double(direction_word(unit.z))};
        const double steps = std::round((hit.position.x - 1) / (words.x * step_word));
        const Vec3 off = hit.position - (rays[i].position + steps * step_word * words);
        ASSERT_LE(std::max({std::abs(off.x), std::abs(off.y), std::abs(off.z)}), 0.5 / kPositionOne + 1e-12)
            << i << " step " << step << " leap " << leap;
      }
    }
  }
}

// Root mean square distance of first hits from where their lines meet the wall.
double first_hit_error(Board& board, double step) {
  std::mt19937 engine(9);
  std::uniform_real_distribution<double> slope(-0.025, 0.025), start(0.5, 1.5);
  std::vector<HostRay> rays;
  for (std::uint32_t i = 0; i < 1500; ++i)
    rays.push_back({.id = i, .position = {start(engine), 16, 16}, .direction = {1, slope(engine), slope(engine)}});
  const RayBatch hits = board.receive(board.submit(rays, {.type = RayType::kFirstHit, .opacity = 0.5, .step = step}));
  constexpr double kThere = kWall - 0.5;  // where the interpolated value is 100
  double sum = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Vec3 wanted = rays[i].position + (kThere - rays[i].position.x) / rays[i].direction.x * rays[i].direction;
    const Vec3 off = hits.rays.at(i).position - wanted;
    sum += dot(off, off);
  }
  return std::sqrt(sum / static_cast<double>(rays.size()));
}

TEST(StabilityOfPositionStepping, OnTheWideDatapathShorterStepsPutFirstHitsNearerToTheirPlace) {
  constexpr const char* kWide = "emu:?set=asic.max_volume_voxels=512&set=asic.datapath=wide";
  Board paper = Board::open("emu:?set=asic.max_volume_voxels=512"), wide = Board::open(kWide);
  load_wall(paper);
  load_wall(wide);
  double last = 1;
  for (const int parts : {8, 16, 32, 64}) {
    const double error = first_hit_error(wide, 1.0 / parts);
    record("first_hits_at_step_1_over_" + std::to_string(parts) + "_paper", first_hit_error(paper, 1.0 / parts));
    record("first_hits_at_step_1_over_" + std::to_string(parts) + "_wide", error);
    EXPECT_LT(error, 0.85 * last) << parts;
    last = error;
  }
  EXPECT_LT(last, 0.02);  // of which the direction's word is 0.012
}

// What it costs: the way to the wall, by a ray's own count of samples, is wrong by at most the drift.
TEST(StabilityOfPositionStepping, HalfVoxelStepsPutAWallInItsPlace) {
  Board board = Board::open("emu:?set=asic.max_volume_voxels=512");
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
