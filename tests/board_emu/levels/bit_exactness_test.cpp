// The board's strongest check: values never depend on the machine. Random scenes through random machines give the bits
// of the functional level, every ray comes back, every cycle has a cause, and nothing locks up.
#include "asic/sorter/policies.h"
#include "random_machine.h"
#include "seeds.h"
#include "test.h"

namespace gicube::emu {
namespace {

class RandomMachine : public testing::TestWithParam<unsigned> {};

TEST_P(RandomMachine, GivesTheBitsOfTheFunctionalLevelAndAccountsForEveryRayAndCycle) {
  Dice dice(GetParam());
  const int n = dice.one_of({8, 8, 16});
  const std::vector<std::string> assignments = draw_machine(dice, n);
  SCOPED_TRACE(text(assignments));
  const v1::BoardConfig config = config_with(assignments);
  Scene scene({dice.number(10, 40), dice.number(10, 40), dice.number(10, 40)}, n, format_of(config));
  draw(scene, dice);
  if (dice.chance(30)) {
    for (auto& entry : scene.segmentation) entry.opacity_fine = static_cast<std::int16_t>(dice.number(-2048, 2047));
    scene.widen();
  }
  const wire::RenderCommand view = draw_view(scene, dice);

  const RunRules runs = runs_of(config);
  const Picture expected = functional_picture(scene, view, runs);
  Machine machine(config, scene.volume.blocks());
  const Picture picture = cycle_picture(scene, view, machine, runs);
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
  EXPECT_EQ(reads, config.ideal().memory() != 0 ? 0 : packets * packets_of_tile(config));
  EXPECT_EQ(machine.dsp().counters().sent, machine.dsp().counters().taken + machine.dsp().counters().overflows);

  const std::vector<wire::Ray> rays = draw_rays(scene, dice);
  std::vector<wire::Ray> functional_rays = rays, cycle_rays = rays;
  trace_functional(functional_rays, scene.frame);
  trace_cycle(cycle_rays, scene.frame, machine);
  EXPECT_EQ(cycle_rays, functional_rays);

  // Ticking in another order changes neither bits nor cycles, and a second frame finds warm caches.
  Machine shuffled(config, scene.volume.blocks());
  shuffled.shuffle_ticks(GetParam() + 1);
  const Picture again = cycle_picture(scene, view, shuffled, runs);
  EXPECT_EQ(again.pixels, expected.pixels);
  EXPECT_EQ(again.ran.cycles, picture.ran.cycles);
  std::vector<wire::Ray> shuffled_rays = rays;
  trace_cycle(shuffled_rays, scene.frame, shuffled);
  EXPECT_EQ(shuffled_rays, functional_rays);
  EXPECT_THAT(counter_texts(shuffled), testing::ElementsAreArray(counter_texts(machine)));

  // Nor do values that are known before their time, unless the queues' order depends on them.
  if (reads_contribution(config.sorter().policy())) return;
  for (const bool saves : {false, true}) {
    Machine ahead(config, scene.volume.blocks());
    const Picture same = ahead_picture(scene, view, ahead, runs, saves);
    EXPECT_EQ(same.pixels, expected.pixels);
    EXPECT_EQ(same.ran.cycles, picture.ran.cycles);
    EXPECT_EQ(same.rays.visible_samples, expected.rays.visible_samples);
    EXPECT_EQ(same.rays.terminated, expected.rays.terminated);
    std::vector<wire::Ray> ahead_rays = rays;
    trace_cycle(ahead_rays, scene.frame, ahead);
    EXPECT_THAT(counter_texts(ahead), testing::ElementsAreArray(counter_texts(machine)));
  }
}

// Machines of the usual kind, which compute many cycles at a time where nobody observes them.
class UsualMachine : public testing::TestWithParam<unsigned> {};

TEST_P(UsualMachine, UnobservedGivesThePicturesAndCountersOfOneThatIsTickedInEachCycle) {
  Dice dice(GetParam() + 100'000);
  const int n = dice.one_of({8, 8, 16});
  std::vector<std::string> assignments = draw_machine(dice, n);
  for (const char* usual : {"sorter.queues=per_block", "cache.ways=1", "cache.tags=of_tiles", "cache.ports=1",
                            "cache.write_policy=combining", "rdram.processors_per_rdram=1",
                            "ddr.processors_per_channel=1", "ideal.memory=0", "ideal.sorter=0"}) {
    assignments.emplace_back(usual);
  }
  assignments.push_back("sorter.policy=" + std::string(dice.one_of({"most_rays", "longest_wait"})));
  if (dice.chance(50)) assignments.emplace_back("asic.processors=" + std::to_string(dice.number(1, 4)));
  SCOPED_TRACE(text(assignments));
  const v1::BoardConfig config = config_with(assignments);
  Scene scene({dice.number(10, 40), dice.number(10, 40), dice.number(10, 40)}, n, format_of(config));
  draw(scene, dice);
  scene.frame.jitter = dice.chance(5);
  wire::RenderCommand view = draw_view(scene, dice);
  if (dice.chance(15)) view = corner_view(scene.volume.size(), dice.number(24, 48));

  const RunRules runs = runs_of(config);
  Machine ticked(config, scene.volume.blocks());
  ticked.shuffle_ticks(GetParam());
  Machine unobserved(config, scene.volume.blocks());
  for (int frame = 0; frame < 2; ++frame) {  // the second finds warm caches
    const Picture expected = cycle_picture(scene, view, ticked, runs);
    const Picture picture = ahead_picture(scene, view, unobserved, runs, false);
    EXPECT_EQ(picture.pixels, expected.pixels);
    EXPECT_EQ(picture.ran.cycles, expected.ran.cycles);
    EXPECT_EQ(picture.ran.dsp_cycles, expected.ran.dsp_cycles);
    EXPECT_EQ(unobserved.now(), ticked.now());
  }
  EXPECT_THAT(counter_texts(unobserved), testing::ElementsAreArray(counter_texts(ticked)));
}

// Without leaping (a leap ends at a block's face) the block size changes no bit either.
TEST(BlockSize, ChangesNoBitWithoutLeaping) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    std::vector<std::uint8_t> expected;
    for (const int n : {8, 16, 32, 64}) {
      Dice dice(seed);
      Scene scene({70, 30, 45}, n);
      draw(scene, dice);
      scene.frame.skip_empty = false;
      const wire::RenderCommand view = corner_view(scene.volume.size(), 24);
      const v1::BoardConfig config = config_with({"asic.block_voxels=" + std::to_string(n), "asic.processors=3",
                                                  "asic.partition=skewed_block", "asic.max_volume_voxels=128"});
      Machine machine(config, scene.volume.blocks());
      const Picture picture = cycle_picture(scene, view, machine);
      if (expected.empty()) expected = functional_picture(scene, view).pixels;
      EXPECT_EQ(picture.pixels, expected) << "n = " << n << ", seed " << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RandomMachine, seeds(240));
INSTANTIATE_TEST_SUITE_P(Scenes, UsualMachine, seeds(2000));

}  // namespace
}  // namespace gicube::emu
