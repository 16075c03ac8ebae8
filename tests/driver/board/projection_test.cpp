// Line integrals and backprojection by host rays, against closed forms and against each other.
#include "test.h"
#include "test_board.h"
#include "voxels.h"

namespace gicube {
namespace {

constexpr int kSize = 32;
constexpr Vec3 kSpacing{0.5, 0.6, 0.75};

double length_of(Vec3 a, Vec3 b) {
  const Vec3 d = b - a;
  return std::hypot(d.x * kSpacing.x, d.y * kSpacing.y, d.z * kSpacing.z);
}

class Projection : public testing::TestWithParam<const char*> {
 protected:
  using Field = std::function<double(int x, int y, int z)>;

  // No transfer function is set: nothing has any opacity.
  void load(const Field& field) {
    values_.clear();
    for_each_voxel({kSize, kSize, kSize},
                   [&](int x, int y, int z) { values_.push_back(static_cast<float>(field(x, y, z))); });
    board_.load_volume({.samples = std::as_bytes(std::span(values_)),
                        .type = SampleType::kFloat32,
                        .dims = {kSize, kSize, kSize},
                        .spacing = kSpacing,
                        .range = ValueRange{0, 4}});
  }
  double integral(Vec3 from, Vec3 to) {
    const HostRay ray = ray_between(3, from, to);
    const RayBatch batch = board_.receive(board_.submit(std::span(&ray, 1), {.type = RayType::kIntegral}));
    EXPECT_EQ(batch.rays.at(0).opacity, 0);
    EXPECT_EQ(batch.rays[0].colour, (std::array<double, 3>{}));
    return batch.rays[0].integral;
  }
  DepositReport backproject(std::span<const HostRay> rays, SumWords words = SumWords::kSums) {
    const RayBatch batch = board_.receive(board_.submit(rays, {.type = RayType::kBackproject, .words = words}));
    EXPECT_TRUE(batch.rays.empty());
    return batch.deposits.value();
  }
  std::vector<float> sums() { return board_.read_sums({{0, 0, 0}, {kSize, kSize, kSize}}); }
  std::vector<HostRay> random_rays(std::size_t count, double least, double most) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> place(0, kSize - 1), energy(least, most);
    std::vector<HostRay> rays;
    while (rays.size() < count) {
      const Vec3 from{place(engine), place(engine), place(engine)}, to{place(engine), place(engine), place(engine)};
      rays.push_back(ray_between(static_cast<std::uint32_t>(rays.size()), from, to));
      rays.back().energy = energy(engine);
    }
    return rays;
  }

  std::vector<float> values_;
  Board board_ =
      Board::open(std::string("emu:?set=asic.block_voxels=8&set=asic.max_volume_voxels=64&fidelity=") + GetParam());
};

TEST_P(Projection, TheIntegralOfAConstantIsItsValueTimesThePhysicalLength) {
  constexpr double kValue = 4.0 * 2559 / 4095;  // a density
  load([](int, int, int) { return kValue; });
  for (const auto& [from, to] :
       {std::pair(Vec3{0, 0, 0}, Vec3{31, 31, 31}), {{3, 4, 5}, {3, 4.1, 5}}, {{30, 2, 7.3}, {1.5, 2, 20}}}) {
    EXPECT_NEAR(integral(from, to), kValue * length_of(from, to), 3e-5 * length_of(from, to));
  }
  EXPECT_EQ(integral({4, 4, 4}, {4, 4, 4}), 0);
}

TEST_P(Projection, TheIntegralOfARampIsThatOfItsMiddle) {
  load([](int x, int y, int) { return 0.05 * x + 0.03 * y; });
  const Vec3 from{1, 2, 3}, to{29, 17, 30};
  const double middle = 0.05 * 15 + 0.03 * 9.5;
  EXPECT_NEAR(integral(from, to), middle * length_of(from, to), 1e-3 * length_of(from, to));
  EXPECT_NEAR(integral(to, from), integral(from, to), 2e-4 * length_of(from, to));
}

TEST_P(Projection, ASpheresChordsAreTheirLengths) {
  constexpr double kRadius = 6;
  load([](int x, int y, int z) {  // as much of each voxel as is inside
    const double r = std::hypot((x - 15.5) * kSpacing.x, (y - 15.5) * kSpacing.y, (z - 15.5) * kSpacing.z);
    return std::clamp((kRadius - r) / 0.6 + 0.5, 0.0, 1.0);
  });
  for (const double y : {15.5, 17.5, 20.5}) {
    const double away = (y - 15.5) * kSpacing.y, chord = 2 * std::sqrt(kRadius * kRadius - away * away);
    EXPECT_NEAR(integral({0, y, 15.5}, {31, y, 15.5}), chord, 0.02 * chord) << y;
  }
  EXPECT_EQ(integral({0, 2, 2}, {31, 2, 2}), 0);
}

TEST_P(Projection, ARayThatLeavesTheVolumeEndsThere) {
  load([](int, int, int) { return 1.0; });
  HostRay ray = ray_between(1, {1, 16, 16}, {31, 16, 16});
  ray.length = 4000;
  const RayBatch batch = board_.receive(board_.submit(std::span(&ray, 1), {.type = RayType::kIntegral}));
  EXPECT_NEAR(batch.rays.at(0).integral, 30 * kSpacing.x, 0.5 * kSpacing.x);
}

TEST_P(Projection, BackprojectionIsTheAdjointOfTheIntegral) {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> value(0, 4);
  load([&](int, int, int) { return value(engine); });
  const auto rays = random_rays(700, -3, 3);
  const RayBatch batch = board_.receive(board_.submit(rays, {.type = RayType::kIntegral}));
  board_.clear_sums(1e-5);
  const DepositReport report = backproject(rays);
  double projected = 0, backprojected = 0, size = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    projected += rays[i].energy * batch.rays[i].integral;
    size += std::abs(rays[i].energy * batch.rays[i].integral);
  }
  const std::vector<float> left = sums();
  for (std::size_t i = 0; i < left.size(); ++i) backprojected += double{left[i]} * double{values_[i]};
  EXPECT_NEAR(backprojected, projected, 2e-4 * size);
  EXPECT_EQ(report.rays, 700u);
  EXPECT_NEAR(std::accumulate(left.begin(), left.end(), 0.0), report.kept, 1e-4 * size);
  EXPECT_EQ(report.clipped, 0);
}

TEST_P(Projection, EachRayLeavesItsEnergyTimesItsLength) {
  load([](int, int, int) { return 0.0; });
  board_.clear_sums(1e-6);
  const Vec3 from{2, 3, 4}, to{25, 30, 9};
  HostRay ray = ray_between(0, from, to);
  ray.energy = -1.5;
  const DepositReport report = backproject(std::span(&ray, 1));
  EXPECT_NEAR(report.kept, -1.5 * length_of(from, to), 1e-4);
  // A second batch adds to it, and clearing begins anew.
  EXPECT_NEAR(backproject(std::span(&ray, 1)).kept, report.kept, 1e-12);
  double all = 0;
  for (const float sum : sums()) all += double{sum};
  EXPECT_NEAR(all, 2 * report.kept, 1e-4);
  board_.clear_sums(1);
  for (const float sum : sums()) ASSERT_EQ(sum, 0);
}

TEST_P(Projection, ARequestsOwnStepIsTaken) {
  load([](int, int, int) { return 0.0; });
  board_.clear_sums(1e-6);
  HostRay ray = ray_between(0, {1, 4, 4}, {21, 4, 4});
  ray.energy = 1;
  for (const double step : {0.25, 1.0, 2.0}) {
    const RayBatch batch =
        board_.receive(board_.submit(std::span(&ray, 1), {.type = RayType::kBackproject, .step = step}));
    EXPECT_EQ(batch.deposits.value().samples, static_cast<std::uint64_t>(20 / step));
    EXPECT_NEAR(batch.deposits->kept, 20 * kSpacing.x, 1e-4);
  }
  EXPECT_THROW(board_.submit(std::span(&ray, 1), {.type = RayType::kBackproject, .step = 0.001}), BadArgument);
}

TEST_P(Projection, IrradianceWordsTakeTheSameUpToTheirRounding) {
  load([](int, int, int) { return 0.0; });
  board_.clear_sums(1e-5);
  board_.clear_irradiance(0.01);
  const auto rays = random_rays(700, 0, 0.2);
  const DepositReport exact = backproject(rays), words = backproject(rays, SumWords::kIrradiance);
  EXPECT_NEAR(words.kept, exact.kept, 0.01 * exact.kept);
  EXPECT_EQ(words.clipped, 0);
  const std::vector<float> irradiance = board_.read_irradiance(), left = sums();
  double difference = 0;
  for (std::size_t i = 0; i < left.size(); ++i) difference += double{irradiance[i]} - double{left[i]};
  EXPECT_NEAR(difference, words.kept - exact.kept, 1e-3 * exact.kept);
  EXPECT_THROWS(BadArgument, "rays[0].energy: expected 0..",
                backproject(random_rays(1, -2, -1), SumWords::kIrradiance));
}

TEST_P(Projection, WordsThatAreFullAreReported) {
  load([](int, int, int) { return 0.0; });
  board_.clear_irradiance(0.001);
  HostRay ray = ray_between(0, {4, 4, 4}, {20, 4, 4});
  ray.energy = 2;
  const std::vector<HostRay> rays(8, ray);
  const DepositReport report = backproject(rays, SumWords::kIrradiance);
  EXPECT_GT(report.clipped, 0);
  EXPECT_NEAR(report.kept + report.clipped, 8 * 2 * 16 * kSpacing.x, 0.1);

  // Full scale, 16 commands' worth in one batch: the driver cuts it so that the board takes it.
  board_.clear_sums(1e-6);
  ray.energy = 16.7;
  const DepositReport many = backproject(std::vector<HostRay>(4096, ray));
  EXPECT_GT(many.overflowed, 0u);
  EXPECT_NEAR(many.kept + many.clipped, 4096 * 16.7 * 16 * kSpacing.x, 1);
  EXPECT_GT(many.clipped, 0.4 * many.kept);
}

TEST_P(Projection, WhatCantBeIsNamed) {
  load([](int, int, int) { return 0.0; });
  HostRay ray = ray_between(0, {4, 4, 4}, {20, 4, 4});
  ray.energy = 1;
  EXPECT_THROWS(Rejected, "clear_sums() first", backproject(std::span(&ray, 1)));
  EXPECT_THROWS(Rejected, "clear_irradiance() first", backproject(std::span(&ray, 1), SumWords::kIrradiance));
  EXPECT_THROW(sums(), Rejected);
  EXPECT_THROW(board_.clear_sums(-1), BadArgument);
  board_.clear_sums(1e-8);
  EXPECT_THROWS(BadArgument, "rays[0].energy: expected -0.335", backproject(std::span(&ray, 1)));
  ray.energy = std::nan("");
  EXPECT_THROW(backproject(std::span(&ray, 1)), BadArgument);
  ray.energy = 0;
  EXPECT_EQ(backproject(std::span(&ray, 1)).kept, 0);
  const Ticket spent = board_.submit(std::span(&ray, 1), {.type = RayType::kBackproject});
  EXPECT_THROW(board_.cancel(spent), Unsupported);
}

INSTANTIATE_TEST_SUITE_P(Levels, Projection, testing::Values("functional", "cycle"));

}  // namespace
}  // namespace gicube
