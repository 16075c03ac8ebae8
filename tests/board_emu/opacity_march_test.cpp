// The vector march of opacity rays gives the bits of the plain way, ray by ray and count by count, on every instruction
// set that this host has.
#include "opacity_march.h"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>

#include "functional.h"
#include "random_machine.h"

namespace gicube::emu {
namespace {

constexpr std::array<int, 3> kSize{45, 21, 34};

struct Rays {
  std::vector<wire::Ray> rays;
  RayCounters counters;
};

Rays plainly(std::vector<wire::Ray> rays, const Frame& frame) {
  Rays out{std::move(rays), {}};
  for (wire::Ray& ray : out.rays) {
    if (ray.flags != 0) integrate(ray, frame, out.counters);
  }
  return out;
}

Rays by_vectors(std::vector<wire::Ray> rays, const Frame& frame, const OpacityMarch& march) {
  Rays out{std::move(rays), {}};
  march.trace(out.rays, frame, out.counters);
  return out;
}

void expect_equal(const Rays& got, const Rays& expected) {
  ASSERT_EQ(got.rays.size(), expected.rays.size());
  for (std::size_t i = 0; i < got.rays.size(); ++i) ASSERT_EQ(got.rays[i], expected.rays[i]) << "ray " << i;
  EXPECT_EQ(got.counters.rays, expected.counters.rays);
  EXPECT_EQ(got.counters.samples, expected.counters.samples);
  EXPECT_EQ(got.counters.visible_samples, expected.counters.visible_samples);
  EXPECT_EQ(got.counters.leaps, expected.counters.leaps);
  EXPECT_EQ(got.counters.terminated, expected.counters.terminated);
}

// On each instruction set for which the march was compiled and that the host has.
template <typename Check>
void on_every_target(const Check& check) {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

void draw_field(Scene& scene, Dice& dice) {
  const bool tagged = dice.chance(50);
  const int air = dice.one_of({0, 0, 300}), radius = dice.number(4, 16);
  scene.fill([&](int x, int y, int z) {
    const int dx = x - 20, dy = y - 10, dz = z - 17, inside = radius * radius - dx * dx - dy * dy - dz * dz;
    wire::Voxel voxel;
    voxel.density = static_cast<std::uint16_t>(inside > 0 ? std::min(4095, 700 + inside * 40) : air);
    voxel.tag = static_cast<std::uint8_t>(tagged ? (x + y / 3) & 3 : 0);
    return voxel;
  });
  const unsigned peak = static_cast<unsigned>(dice.one_of({3, 900, 20'000, 65'535}));
  for (std::size_t i = 0; i < scene.segmentation.size(); ++i) {
    const auto density = static_cast<unsigned>(i % 4096);
    const unsigned opacity = density < 250 ? 0 : std::min(65'535u, 1 + peak * density / 3000 + (i > 4095 ? 200 : 0));
    scene.segmentation[i].opacity = static_cast<std::uint16_t>(opacity);
  }
  Frame& frame = scene.frame;
  frame.segments = frame.colourless = frame.to_the_hit = frame.plain = true;
  frame.jitter = frame.shade = false;
  frame.cut_planes.clear();
  frame.leap = dice.chance(60);
  frame.step = static_cast<std::uint32_t>(dice.one_of({9'000, 32'768, 65'536, 150'000}));
  frame.opacity_threshold = dice.one_of<std::uint32_t>({1, wire::kOpacityOne / 3, wire::kOpacityOne});
  if (dice.chance(50)) frame.spacing = {65'536, 90'000, 131'072};
  for (std::uint8_t& flag : frame.empty) flag = dice.chance(40) ? 1 : 0;  // a wrong flag changes both ways alike
}

// Anywhere in the volume: also on its faces, along axes, of no length, and out of it.
std::vector<wire::Ray> draw_segments(Dice& dice, int count) {
  std::vector<wire::Ray> rays;
  for (int i = 0; i < count; ++i) {
    std::array<double, 3> position{}, direction{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int last = kSize[axis] - 1;
      position[axis] = dice.chance(15) ? dice.one_of({0, 8, 16, last}) : dice.number(0, last * 100) / 100.0;
      direction[axis] = dice.chance(20) ? 0 : dice.number(-100, 100);
    }
    if (direction == std::array<double, 3>{}) direction[2] = 1;
    wire::Ray ray = host_ray(static_cast<std::uint32_t>(i + 1), position, direction);
    ray.set_colour_word(static_cast<std::uint64_t>(dice.one_of({0, 1, 700, dice.number(0, 60 << 16)})));
    if (dice.chance(5)) ray.flags = 0;
    rays.push_back(ray);
  }
  return rays;
}

class OpacityMarchOfRandomScenes : public testing::TestWithParam<unsigned> {};

TEST_P(OpacityMarchOfRandomScenes, GivesTheBitsOfThePlainWay) {
  Dice dice(GetParam());
  Scene scene(kSize, dice.one_of({8, 16, 32}));
  draw_field(scene, dice);
  OpacityMarch march(scene.opacity_correction);
  ASSERT_TRUE(march.prepare(1 << 20, scene.frame, 0, 2));
  const auto rays = draw_segments(dice, dice.one_of({1, 15, 16, 17, 300}));
  const Rays expected = plainly(rays, scene.frame);
  on_every_target([&] { expect_equal(by_vectors(rays, scene.frame, march), expected); });
}

INSTANTIATE_TEST_SUITE_P(Scenes, OpacityMarchOfRandomScenes, testing::Range(1u, 201u));

TEST(OpacityMarch, FollowsTheVolumeAndTheLut) {
  Dice dice(7);
  Scene scene(kSize, 16);
  draw_field(scene, dice);
  OpacityMarch march(scene.opacity_correction);
  ASSERT_TRUE(march.prepare(1 << 20, scene.frame, 0, 1));
  const auto rays = draw_segments(dice, 200);
  const Rays before = by_vectors(rays, scene.frame, march);

  scene.fill([](int x, int, int) { return wire::Voxel{.density = static_cast<std::uint16_t>(80 * x)}; });
  ASSERT_TRUE(march.prepare(1 << 20, scene.frame, 0, 1));
  const Rays refilled = by_vectors(rays, scene.frame, march);
  expect_equal(refilled, plainly(rays, scene.frame));
  EXPECT_NE(refilled.counters.visible_samples, before.counters.visible_samples);

  for (auto& entry : scene.segmentation) entry.opacity = 77;
  ASSERT_TRUE(march.prepare(1 << 20, scene.frame, 1, 1));
  expect_equal(by_vectors(rays, scene.frame, march), plainly(rays, scene.frame));
}

TEST(OpacityMarch, IsNotReadyForFewRaysNorForMoreThanOpacity) {
  Dice dice(3);
  Scene scene(kSize, 8);
  draw_field(scene, dice);
  OpacityMarch march(scene.opacity_correction);
  EXPECT_FALSE(march.prepare(1, scene.frame, 0, 1));  // a copy of the volume for one ray would be a bad bargain
  EXPECT_TRUE(march.prepare(scene.volume.stored_blocks(), scene.frame, 0, 1));
  Frame coloured = scene.frame;
  coloured.colourless = false;
  EXPECT_FALSE(march.prepare(1 << 20, coloured, 0, 1));
  Frame jittered = scene.frame;
  jittered.jitter = true;
  EXPECT_FALSE(march.prepare(1 << 20, jittered, 0, 1));
}

}  // namespace
}  // namespace gicube::emu
