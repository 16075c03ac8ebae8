// Ray marching and leaping: rays without or with tiny components, in faces, edges and corners of blocks and of the
// volume.
#include <array>
#include <cmath>
#include <cstdint>
#include <string>

#include "stability.h"

namespace gicube::stability {
namespace {

constexpr std::array<int, 3> kSize{40, 33, 20};
constexpr int kBlock = 8;
constexpr double kAlpha = 66 / 65'535.0;

// The expected path of one ray, in whole numbers of its words.
struct Expected {
  std::int64_t samples = 0;  // in visible blocks
  std::int64_t blocks = 0;   // that it comes through
};

class StabilityOfMarching : public testing::TestWithParam<const char*> {
 protected:
  StabilityOfMarching() : board_(Board::open(small_board(std::string("&fidelity=") + GetParam()))) {
    load_fog(board_, {kSize[0], kSize[1], kSize[2]}, kAlpha);
  }

  // From faces, edges and corners of the volume and of blocks, one unit beside them and elsewhere; along the axes,
  // along diagonals, in planes, and off them by one unit of the direction's words or less.
  static std::vector<HostRay> rays(std::size_t take_one_in) {
    constexpr double kUnit = 1 / kPositionOne;
    std::vector<HostRay> all;
    std::size_t number = 0;
    for (const double x : {0.0, 8.0, 16 - kUnit, 24 + kUnit, 12.3, 39.0}) {
      for (const double y : {0.0, 16.0, 8 - kUnit, 21.7, 32.0}) {
        for (const double z : {0.0, 8.0, 16 + kUnit, 5.5, 19.0}) {
          for (const double dx : {0.0, 1.0, -1.0, kUnit, -0.4 * kUnit}) {
            for (const double dy : {0.0, 1.0, -1.0, -kUnit, 0.6 * kUnit}) {
              for (const double dz : {0.0, 1.0, -1.0, 2 * kUnit}) {
                if (std::abs(dx) + std::abs(dy) + std::abs(dz) < 1 || number++ % take_one_in != 0) continue;
                all.push_back(
                    {.id = static_cast<std::uint32_t>(all.size()), .position = {x, y, z}, .direction = {dx, dy, dz}});
              }
            }
          }
        }
      }
    }
    return all;
  }

  static std::int64_t block_of(const std::array<std::int64_t, 3>& at) {
    const auto along = [&](std::size_t axis) { return at[axis] / (kBlock * static_cast<std::int64_t>(kPositionOne)); };
    return along(0) + 5 * (along(1) + 5 * along(2));
  }

  template <typename Visible>
  static Expected expected(const HostRay& ray, double step, const Visible& visible) {
    const double length = std::hypot(ray.direction.x, ray.direction.y, ray.direction.z);
    std::array<std::int64_t, 3> at{std::lround(ray.position.x * kPositionOne),
                                   std::lround(ray.position.y * kPositionOne),
                                   std::lround(ray.position.z * kPositionOne)};
    std::array<std::int64_t, 3> move{};
    const std::array<double, 3> direction{ray.direction.x, ray.direction.y, ray.direction.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto word = static_cast<double>(std::lround(direction[axis] / length * kDirectionOne));
      move[axis] = static_cast<std::int64_t>(std::floor(word * step + 0.5));
    }
    Expected out;
    std::int64_t block = -1;
    const auto is_inside = [&] {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (at[axis] < 0 || at[axis] > (kSize[axis] - 1) * static_cast<std::int64_t>(kPositionOne)) return false;
      }
      return true;
    };
    for (; is_inside(); at = {at[0] + move[0], at[1] + move[1], at[2] + move[2]}) {
      if (block_of(at) != block) ++out.blocks;
      block = block_of(at);
      if (visible(block)) ++out.samples;
    }
    return out;
  }

  // Traces them and holds each ray's opacity, and with it the number and the place of its samples, against its words.
  template <typename Visible>
  void hold(const std::vector<HostRay>& all, double step, bool leap, const Visible& visible) {
    const Counters before = board_.counters();
    const RayBatch batch = board_.receive(board_.submit(all, {.step = step, .leap = leap}));
    const Counters window = board_.counters() - before;
    ASSERT_EQ(batch.rays.size(), all.size());
    std::uint64_t samples = 0, max_leaps = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const Expected ray = expected(all[i], step, visible);
      const double max_steps = 40 * std::sqrt(3.0) / step + 1 + 15;
      ASSERT_LE(static_cast<double>(ray.samples), max_steps);
      const double opacity = 1 - std::pow(1 - kAlpha, static_cast<double>(ray.samples) * step);
      ASSERT_NEAR(batch.rays[i].opacity, opacity, (1e-7 + 8e-8 * step) * static_cast<double>(ray.samples) + 1e-9)
          << i << " step " << step;
      const Vec3 end = batch.rays[i].position;
      ASSERT_TRUE(end.x >= 0 && end.x <= 39 && end.y >= 0 && end.y <= 32 && end.z >= 0 && end.z <= 19) << i;
      samples += static_cast<std::uint64_t>(ray.samples);
      max_leaps += static_cast<std::uint64_t>(ray.blocks);
    }
    EXPECT_EQ(window.value("pipeline.samples"), samples) << "step " << step;
    EXPECT_LE(window.value("pipeline.leaps"), max_leaps) << "step " << step;
    EXPECT_GT(samples, 0u);
  }

  bool is_cycle() const { return std::string_view(GetParam()) == "cycle"; }

  Board board_;
};

TEST_P(StabilityOfMarching, EveryRayTakesTheSamplesThatItsWordsSayAndNoneOutside) {
  for (const double step : {1.0 / 64, 0.5, 16.0}) {
    hold(rays(is_cycle() ? 97 : step < 0.1 ? 5 : 1), step, false, [](std::int64_t) { return true; });
  }
}

TEST_P(StabilityOfMarching, LeapsNeverStallNorPassASampleOfAVisibleBlock) {
  std::vector<std::uint8_t> empty(5 * 5 * 3);
  for (std::size_t i = 0; i < empty.size(); ++i) empty[i] = i % 3 != 0;
  board_.set_empty_flags(empty);
  for (const double step : {1.0 / 64, 0.5, 16.0}) {
    hold(rays(is_cycle()   ? 97
              : step < 0.1 ? 5
                           : 1),
         step, true, [&](std::int64_t block) { return empty[static_cast<std::size_t>(block)] == 0; });
  }
}

TEST_P(StabilityOfMarching, ThroughEmptyBlocksAloneARayTakesAtMostOneTurnABlock) {
  board_.set_empty_flags(std::vector<std::uint8_t>(5 * 5 * 3, 1));
  const auto all = rays(is_cycle() ? 97 : 3);
  const Counters before = board_.counters();
  board_.receive(board_.submit(all, {.step = 1.0 / 64}));
  const Counters window = board_.counters() - before;
  EXPECT_EQ(window.value("pipeline.samples"), 0u);
  std::uint64_t blocks = 0;
  for (const HostRay& ray : all)
    blocks += static_cast<std::uint64_t>(expected(ray, 1.0 / 64, [](std::int64_t) { return false; }).blocks);
  EXPECT_EQ(window.value("pipeline.leaps"), blocks);
  record(std::string("leaps_a_ray_") + GetParam(), ratio(blocks, all.size()));
}

INSTANTIATE_TEST_SUITE_P(Levels, StabilityOfMarching, testing::Values("functional", "cycle"),
                         [](const auto& level) { return std::string(level.param); });

}  // namespace
}  // namespace gicube::stability
