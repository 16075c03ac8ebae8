// The board's strongest check: values never depend on the machine. Random scenes through random machines give the bits of
// the functional level, every ray comes back, every cycle has a cause, and nothing locks up.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "bare_board.h"
#include "machine_rig.h"

namespace gicube::emu {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : engine_(seed) {}
  int number(int low, int high) { return low + static_cast<int>(engine_() % static_cast<unsigned>(high - low + 1)); }
  bool chance(int percent) { return number(1, 100) <= percent; }
  template <typename T>
  T one_of(std::initializer_list<T> values) {
    return *(values.begin() + number(0, static_cast<int>(values.size()) - 1));
  }

 private:
  std::mt19937 engine_;
};

// Balls of different materials in clear air, with shading, jitter, leaping, termination and cut planes drawn.
void draw(Scene& scene, Dice& dice) {
  struct Ball {
    std::array<int, 3> centre;
    int radius;
    std::uint8_t tag;
  };
  const std::array<int, 3>& size = scene.volume.size();
  std::vector<Ball> balls;
  for (int i = dice.number(0, 4); i >= 0; --i) {
    balls.push_back({{dice.number(0, size[0]), dice.number(0, size[1]), dice.number(0, size[2])},
                     dice.number(2, 14),
                     static_cast<std::uint8_t>(dice.number(0, 3))});
  }
  scene.fill([&](int x, int y, int z) {
    wire::Voxel voxel;
    for (const Ball& ball : balls) {
      const int dx = x - ball.centre[0], dy = y - ball.centre[1], dz = z - ball.centre[2];
      const int inside = ball.radius * ball.radius - dx * dx - dy * dy - dz * dz;
      if (inside <= 0) continue;
      voxel.density = static_cast<std::uint16_t>(std::min(4095, voxel.density + 900 + inside * 20));
      voxel.gradient = static_cast<std::uint16_t>((x * 7 + y * 131 + z * 31) % 2048);
      voxel.tag = ball.tag;
    }
    return voxel;
  });
  const int clear = dice.number(200, 1500), peak = dice.one_of({300, 6000, 65535});
  for (std::size_t i = 0; i < scene.segmentation.size(); ++i) {
    const int density = static_cast<int>(i & 4095);
    wire::SegmentationEntry& entry = scene.segmentation[i];
    entry.opacity = static_cast<std::uint16_t>(density < clear ? 0 : std::min(65535, peak * (density - clear) / 2048));
    entry.colour = {static_cast<std::uint16_t>(density), static_cast<std::uint16_t>(4095 - density / 2),
                    static_cast<std::uint16_t>(1000 * (i >> 12))};
    entry.ambient = 40;
    entry.knee = 128;
    entry.reflect = 128;
  }
  scene.frame.shade = dice.chance(70);
  scene.frame.jitter = dice.chance(40);
  scene.frame.leap = dice.chance(60);
  scene.frame.step = static_cast<std::uint32_t>(dice.one_of({20'000, 32'768, 65'536, 150'000}));
  scene.frame.opacity_threshold = dice.one_of<std::uint32_t>({wire::kOpacityOne, wire::kOpacityOne / 2, 0});
  if (dice.chance(80)) scene.frame.opacity_threshold = wire::kOpacityOne / 16 * 15;
  if (dice.chance(25)) {
    scene.frame.cut_planes.push_back(
        {{wire::kVoxel, 0, dice.number(-5000, 5000)}, std::int64_t{dice.number(-4, 12)} << kPlaneFractionBits});
  }
  // A flag only promises that nothing is visible; a wrong one changes both levels alike.
  for (auto& flag : scene.frame.empty) flag = dice.chance(25) ? 1 : 0;
}

std::vector<std::string> draw_machine(Dice& dice, int block_voxels) {
  const auto set = [](const char* field, auto value) { return std::string(field) + '=' + std::to_string(value); };
  const auto name = [](const char* field, const char* value) { return std::string(field) + '=' + value; };
  return {
      set("asic.block_voxels", block_voxels),
      set("asic.processors", dice.number(1, 16)),
      set("asic.queue_rays", dice.one_of({1, 2, 3, 8, 40, 256})),
      name("asic.partition", dice.one_of({"simple_slab", "repeated_slab", "skewed_block"})),
      name("sorter.policy", dice.one_of({"most_rays", "most_contribution"})),
      name("sorter.queues", dice.chance(15) ? "single" : "per_block"),
      set("pipeline.prefetch_stages", dice.one_of({1, 3, 16, 40})),
      set("pipeline.compute_stages", dice.one_of({1, 5, 16})),
      set("cache.ways", dice.one_of({1, 1, 2, 8})),
      set("cache.miss_packets", dice.one_of({8, 32, 100})),
      set("link.bits", dice.one_of({1, 8, 32, 256})),
      set("link.rays", dice.one_of({2, 4})),
      set("rdram.processors_per_rdram", dice.number(1, 2)),
      set("rdram.clocks_per_core_cycle", dice.one_of({1, 4, 8})),
      set("rdram.refresh_interval", dice.one_of({0, 100, 781})),
      set("dsp.viewing_ray_cycles", dice.one_of({0, 2, 20})),
      set("dsp.returned_ray_cycles", dice.one_of({0, 8})),
      set("dsp.overflow_ray_cycles", dice.one_of({0, 1, 12})),
      set("dsp.run_rays", dice.one_of({0, 0, 4, 64})),
      set("ideal.memory", dice.chance(10) ? 1 : 0),
      set("ideal.queues", dice.chance(10) ? 1 : 0),
      set("ideal.sorter", dice.chance(10) ? 1 : 0),
  };
}

wire::RenderCommand draw_view(const Scene& scene, Dice& dice) {
  wire::RenderCommand view = corner_view(scene.volume.size(), dice.number(5, 24));
  if (dice.chance(30)) {  // straight along an axis, where all rays of a row stay together
    const double extent = scene.volume.size()[1];
    view.projection = wire::Projection::kOrthographic;
    view.origin = {-5, -1, -1};
    view.forward = {1, 0, 0};
    view.du = {0, (extent + 2) / view.width, 0};
    view.dv = {0, 0, (extent + 2) / view.height};
  }
  view.samples_per_axis = dice.chance(20) ? 2 : 1;
  return view;
}

// Host rays from anywhere in the volume to anywhere; some carry what an earlier flight gathered.
std::vector<wire::Ray> draw_rays(const Scene& scene, Dice& dice) {
  std::vector<wire::Ray> rays;
  for (int i = dice.number(0, 60); i > 0; --i) {
    std::array<double, 3> position{}, direction{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = dice.number(0, (scene.volume.size()[axis] - 1) * 100) / 100.0;
      direction[axis] = dice.number(-100, 100) + 0.5;
    }
    rays.push_back(host_ray(static_cast<std::uint32_t>(dice.number(0, 1 << 20)), position, direction));
    rays.back().opacity =
        static_cast<std::uint32_t>(dice.chance(20) ? dice.number(0, 1 << 24) - 1 : 0) & wire::kOpacityOne;
  }
  return rays;
}

std::string text(const std::vector<std::string>& assignments) {
  return std::accumulate(assignments.begin(), assignments.end(), std::string(),
                         [](const std::string& all, const std::string& one) { return all + " --set " + one; });
}

std::vector<std::string> counter_texts(const Machine& machine) {
  std::vector<wire::Counter> counters;
  count(machine, counters);
  std::vector<std::string> texts;
  for (const auto& counter : counters) texts.push_back(counter.name + ' ' + std::to_string(counter.value));
  return texts;
}

class RandomMachine : public testing::TestWithParam<unsigned> {};

TEST_P(RandomMachine, GivesTheBitsOfTheFunctionalLevelAndAccountsForEveryRayAndCycle) {
  Dice dice(GetParam());
  const int n = dice.one_of({8, 8, 16});
  Scene scene({dice.number(10, 40), dice.number(10, 40), dice.number(10, 40)}, n);
  draw(scene, dice);
  const wire::RenderCommand view = draw_view(scene, dice);
  const std::vector<std::string> assignments = draw_machine(dice, n);
  SCOPED_TRACE(text(assignments));
  const v1::BoardConfig config = config_with(assignments);

  const Picture expected = functional_picture(scene, view);
  Machine machine(config, scene.volume.blocks());
  const Picture picture = cycle_picture(scene, view, config, machine);
  EXPECT_EQ(picture.pixels, expected.pixels);
  EXPECT_EQ(picture.rays.rays, expected.rays.rays);
  EXPECT_EQ(picture.rays.samples, expected.rays.samples);
  EXPECT_EQ(picture.rays.visible_samples, expected.rays.visible_samples);
  EXPECT_EQ(picture.rays.leaps, expected.rays.leaps);
  EXPECT_EQ(picture.rays.terminated, expected.rays.terminated);

  std::uint64_t packets = 0, issued = 0;
  for (const auto& processor : machine.processors()) {
    const CauseCounts& causes = processor->causes();
    EXPECT_EQ(std::accumulate(causes.begin(), causes.end(), std::uint64_t{0}), machine.now());
    EXPECT_EQ(causes[static_cast<std::size_t>(Cause::kBusy)], processor->rays().samples);
    EXPECT_EQ(causes[static_cast<std::size_t>(Cause::kLeap)], processor->rays().leaps);
    EXPECT_TRUE(processor->idle());
    packets += processor->cache().counters().packets;
    issued += processor->sorter().counters().issued;
  }
  EXPECT_EQ(issued, picture.rays.samples + picture.rays.leaps);
  std::uint64_t reads = 0;
  for (const auto& memory : machine.memories()) reads += memory->channel().counters().packets_read;
  EXPECT_EQ(reads, config.ideal().memory() != 0 ? 0 : packets);
  EXPECT_EQ(machine.dsp().counters().sent, machine.dsp().counters().taken + machine.dsp().counters().overflows);

  const std::vector<wire::Ray> rays = draw_rays(scene, dice);
  std::vector<wire::Ray> functional_rays = rays, cycle_rays = rays;
  trace(functional_rays, scene.frame, 1);
  Work work;
  trace(cycle_rays, scene.frame, config.dsp(), machine, work);
  EXPECT_EQ(cycle_rays, functional_rays);

  // Ticking in another order changes neither bits nor cycles, and a second frame finds warm caches.
  Machine shuffled(config, scene.volume.blocks());
  shuffled.shuffle_ticks(GetParam() + 1);
  const Picture again = cycle_picture(scene, view, config, shuffled);
  EXPECT_EQ(again.pixels, expected.pixels);
  EXPECT_EQ(again.ran.cycles, picture.ran.cycles);
  std::vector<wire::Ray> shuffled_rays = rays;
  trace(shuffled_rays, scene.frame, config.dsp(), shuffled, work);
  EXPECT_EQ(shuffled_rays, functional_rays);
  EXPECT_THAT(counter_texts(shuffled), testing::ElementsAreArray(counter_texts(machine)));
}

// Without leaping (a leap ends at a block's face) the block size changes no bit either.
TEST(BlockSize, ChangesNoBitWithoutLeaping) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::vector<std::uint8_t> expected;
    for (const int n : {8, 16, 32, 64}) {
      Dice dice(seed);
      Scene scene({70, 30, 45}, n);
      draw(scene, dice);
      scene.frame.leap = false;
      const wire::RenderCommand view = corner_view(scene.volume.size(), 24);
      const v1::BoardConfig config = config_with({"asic.block_voxels=" + std::to_string(n), "asic.processors=3",
                                                  "asic.partition=skewed_block", "asic.max_volume_voxels=128"});
      Machine machine(config, scene.volume.blocks());
      const Picture picture = cycle_picture(scene, view, config, machine);
      if (expected.empty()) expected = functional_picture(scene, view).pixels;
      EXPECT_EQ(picture.pixels, expected) << "n = " << n << ", seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RandomMachine, testing::Range(1u, 241u));

}  // namespace
}  // namespace gicube::emu
