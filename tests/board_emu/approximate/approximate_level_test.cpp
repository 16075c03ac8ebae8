// The approximate level: the values of the other levels, and about the time, the traffic and the hits of the cycle level.
#include "approximate/approximate_level.h"

#include <gtest/gtest.h>

#include <cmath>

#include "approximate/traced_passes.h"
#include "asic/memory_standards.h"
#include "bare_board.h"
#include "firmware/ray_sources/image_rays.h"
#include "machine_rig.h"

namespace gicube::emu {
namespace {

constexpr int kEdge = 96;
constexpr int kBlock = 16;

// A ball, or all of a cube, in clear air.
void fill(Scene& scene, bool cube) {
  const auto density = [cube](int x, int y, int z) {
    const double dx = x - 47.5, dy = y - 47.5, dz = z - 47.5, r = std::sqrt(dx * dx + dy * dy + dz * dz);
    return cube ? 2500.0 : std::clamp((38 - r) / 4 + 0.5, 0.0, 1.0) * 4095;
  };
  scene.fill([&](int x, int y, int z) {
    return wire::Voxel{static_cast<std::uint16_t>(density(x, y, z)), static_cast<std::uint16_t>(x * 7 % 2048), 0, 0};
  });
  for (std::size_t block = 0; block < scene.frame.empty.size(); ++block) {
    const auto nearest = [](std::size_t b) {
      const int low = static_cast<int>(b) * kBlock;
      return std::clamp(47, low, low + kBlock);
    };
    const std::size_t n = kEdge / kBlock;
    scene.frame.empty[block] = density(nearest(block % n), nearest(block / n % n), nearest(block / (n * n))) == 0;
  }
}

struct Case {
  std::string name;
  std::vector<std::string> machine;
  int image = 96;
  bool cube = false, leap = true;
  std::uint16_t opacity = 800;
  bool jitter = false, wide = false;
  double max_error = 0.03;  // of time, packets and hit ratio
};

void set_up(Scene& scene, const Case& test) {
  fill(scene, test.cube);
  for (std::size_t i = 0; i < scene.segmentation.size(); ++i) {
    scene.segmentation[i] = {{4000, 3000, 2000}, (i & 4095) > 2048 ? test.opacity : std::uint16_t{0}, 40, 128, 128, 0};
  }
  scene.frame.step = wire::kStepOne / 2;
  scene.frame.opacity_threshold = wire::kOpacityOne / 50 * 49;
  scene.frame.shade = true;
  scene.frame.leap = test.leap;
  scene.frame.jitter = test.jitter;
  if (test.wide) scene.widen();
}

struct Figures {
  double cycles = 0, packets = 0, hits = 0;
};

std::uint64_t value(const std::vector<wire::Counter>& list, const std::string& name) {
  for (const wire::Counter& counter : list) {
    if (counter.name == name) return counter.value;
  }
  ADD_FAILURE() << name;
  return 0;
}

Figures figures(const RunResult& ran, const std::vector<wire::Counter>& list, const std::string& memory) {
  const auto of = [&list](const std::string& name) { return static_cast<double>(value(list, name)); };
  return {static_cast<double>(ran.cycles), of(memory + ".reads"),
          1 - of("processor.cache.missed_voxels") / (8 * of("processor.cache.checks"))};
}

class ApproximateLevel : public testing::TestWithParam<Case> {
 protected:
  ApproximateLevel() : scene_({kEdge, kEdge, kEdge}, kBlock) {
    set_up(scene_, GetParam());
    std::vector<std::string> assignments = GetParam().machine;
    assignments.push_back("asic.block_voxels=" + std::to_string(kBlock));
    assignments.push_back("asic.max_volume_voxels=128");
    config_ = config_with(assignments);
  }

  Scene scene_;
  v1::BoardConfig config_;
};

TEST_P(ApproximateLevel, HasTheValuesAndAboutTheTimeAndTheTrafficOfTheCycleLevel) {
  const wire::RenderCommand view = corner_view({kEdge, kEdge, kEdge}, GetParam().image);
  Machine machine(config_, scene_.volume.blocks());
  const RunRules runs = runs_of(config_);
  const Picture exact = cycle_picture(scene_, view, machine, runs);
  std::vector<wire::Counter> list;
  count(machine, list);
  const Figures expected = figures(exact.ran, list, memory_standard(config_).name);

  PassMachine turns(config_, scene_.volume.blocks());
  Framebuffer framebuffer;
  Progress work;
  ImageRays source(view, scene_.frame, framebuffer, runs);
  TracedPasses passes(source, {0, source.count()}, scene_.frame, nullptr, 1);
  const RunResult ran = turns.run(passes, scene_.frame, work, false);
  const RayCounters& rays = passes.rays();
  std::vector<wire::Counter> turn_list;
  turns.count(turn_list);
  const Figures got = figures(ran, turn_list, memory_standard(config_).name);

  EXPECT_EQ(framebuffer.packed(), exact.pixels);
  EXPECT_EQ(rays.samples, exact.rays.samples);
  EXPECT_EQ(rays.leaps, exact.rays.leaps);
  EXPECT_EQ(rays.rays, exact.rays.rays);
  if (!GetParam().jitter) {  // whose ways are gone in even steps
    EXPECT_EQ(value(turn_list, "processor.samples"), exact.rays.samples);
    EXPECT_EQ(value(turn_list, "link.rays_sent"), value(list, "link.rays_sent"));
  }
  EXPECT_EQ(value(turn_list, "dsp.rays_taken"), value(list, "dsp.rays_taken"));
  EXPECT_NEAR(got.cycles / expected.cycles, 1, GetParam().max_error);
  EXPECT_NEAR(got.packets / expected.packets, 1, GetParam().max_error);
  EXPECT_NEAR(got.hits / expected.hits, 1, GetParam().max_error);
  std::printf("%-24s cycles %+.2f%%, packets %+.2f%%, hit ratio %.4f against %.4f\n", GetParam().name.c_str(),
              100 * (got.cycles / expected.cycles - 1), 100 * (got.packets / expected.packets - 1), got.hits,
              expected.hits);
}

INSTANTIATE_TEST_SUITE_P(
    Of, ApproximateLevel,
    testing::Values(
        Case{.name = "translucent_ball", .machine = {}}, Case{.name = "opaque_ball", .machine = {}, .opacity = 40'000},
        Case{.name = "cube_without_leaps", .machine = {}, .cube = true, .leap = false, .opacity = 60},
        Case{.name = "fast_dsp", .machine = {"dsp.clock_khz=1000000"}, .opacity = 300},
        Case{.name = "skewed_blocks_fast_dsp",
             .machine = {"asic.partition=skewed_block", "asic.processors=8", "dsp.clock_khz=1000000",
                         "sdram.clock_khz=500000"}},
        Case{.name = "short_queues", .machine = {"asic.queue_rays=16", "dsp.clock_khz=1000000"}, .max_error = 0.04},
        Case{.name = "narrow_links",
             .machine = {"asic.partition=skewed_block", "asic.processors=8", "link.bits=16", "link.rays=2"},
             .max_error = 0.07},
        Case{.name = "wide_datapath", .machine = {"asic.datapath=wide"}, .wide = true},
        Case{.name = "wide_datapath_jittered",
             .machine = {"asic.datapath=wide"},
             .opacity = 300,
             .jitter = true,
             .wide = true},
        Case{.name = "four_ways", .machine = {"cache.ways=4"}},
        Case{.name = "longest_wait", .machine = {"sorter.policy=longest_wait", "dsp.clock_khz=1000000"}},
        Case{.name = "ideal_sorter", .machine = {"ideal.sorter=1", "dsp.clock_khz=1000000"}},
        Case{.name = "ddr", .machine = {"memory=ddr", "dsp.clock_khz=1000000"}},
        Case{.name = "one_processor", .machine = {"asic.processors=1"}},
        Case{.name = "most_contribution",
             .machine = {"sorter.policy=most_contribution", "dsp.clock_khz=1000000"},
             .opacity = 300},
        Case{.name = "two_ports", .machine = {"cache.ports=2", "dsp.clock_khz=1000000"}},
        Case{.name = "shared_rdram",
             .machine = {"rdram.processors_per_rdram=2", "asic.processors=4", "dsp.clock_khz=1000000",
                         "sdram.clock_khz=500000"}},
        Case{.name = "shared_ddr",
             .machine = {"memory=ddr", "ddr.processors_per_channel=2", "asic.processors=8",
                         "asic.partition=skewed_block", "dsp.clock_khz=1000000"}},
        Case{.name = "runs_of_rays", .machine = {"dsp.run_rays=16"}},
        Case{.name = "jittered", .machine = {}, .jitter = true}),
    [](const auto& test) { return test.param.name; });

// A step of which one coordinate is larger than a block is long.
TEST(ApproximateBoard, TakesStepsThatAreLongerThanABlock) {
  const auto render = [](const char* fidelity) {
    BareBoard board(config_with({fidelity, "asic.block_voxels=8", "asic.max_volume_voxels=128"}));
    board.load_volume({64, 64, 64}, [](int x, int y, int z) {
      return wire::Voxel{static_cast<std::uint16_t>(20 * x + 20 * y + z), 0, 0, 0};
    });
    board.write_segmentation([](unsigned, unsigned) { return wire::SegmentationEntry{{4000, 3000, 2000}, 100}; });
    board.write_register(wire::reg::kStep, 12 * wire::kStepOne);
    const std::uint64_t begin = board.now_ps;
    board.render(corner_view({64, 64, 64}, 32));
    return std::pair(board.counter("pipeline.samples"), static_cast<double>(board.now_ps - begin));
  };
  const auto [samples, time] = render("fidelity=approximate");
  const auto [expected_samples, expected_time] = render("fidelity=cycle");
  EXPECT_EQ(samples, expected_samples);
  EXPECT_NEAR(time / expected_time, 1, 0.03);
}

TEST(ApproximateBoard, SaysWhichLevelAnsweredEachCommand) {
  BareBoard board(config_with({"fidelity=approximate", "asic.block_voxels=16", "asic.max_volume_voxels=128"}));
  board.load_volume({32, 32, 32}, [](int x, int y, int) {
    return wire::Voxel{static_cast<std::uint16_t>(100 * x + y), 0, 0, 0};
  });
  board.write_segmentation([](unsigned, unsigned) { return wire::SegmentationEntry{{4000, 3000, 2000}, 800}; });
  const auto answered = [&board](const char* level) {
    return board.counter(std::string("fidelity_answered.") + level);
  };
  board.render(corner_view({32, 32, 32}, 16));
  board.render(corner_view({32, 32, 32}, 16));
  EXPECT_EQ(answered("approximate"), 2u);
  board.write_register(wire::reg::kPipeline, wire::kPipelineIrradiance);
  board.render(corner_view({32, 32, 32}, 16));
  EXPECT_EQ(answered("approximate"), 3u);
  EXPECT_EQ(answered("cycle"), 0u);
  EXPECT_EQ(answered("functional"), 0u);
}

TEST(PassMachine, GoesOnFromFrameToFrameWithWarmCaches) {
  constexpr int kOneBlock = 15;  // which stays in its processor's cache
  Scene scene({kOneBlock, kOneBlock, kOneBlock}, kBlock);
  set_up(scene, {.name = "cube", .machine = {}, .cube = true});
  const v1::BoardConfig config = config_with({"asic.block_voxels=16", "asic.max_volume_voxels=128"});
  const wire::RenderCommand view = corner_view({kOneBlock, kOneBlock, kOneBlock}, 48);
  struct Frame {
    Cycle cycles = 0;
    std::uint64_t reads = 0, all_cycles = 0;
  };
  const auto run = [&](PassMachine& machine, unsigned threads) {
    std::vector<wire::Counter> before, after;
    machine.count(before);
    Framebuffer framebuffer;
    Progress work;
    ImageRays source(view, scene.frame, framebuffer);
    TracedPasses passes(source, {0, source.count()}, scene.frame, nullptr, threads);
    const RunResult ran = machine.run(passes, scene.frame, work, threads > 1);
    machine.count(after);
    return Frame{ran.cycles, value(after, "rdram.reads") - value(before, "rdram.reads"), value(after, "asic.cycles")};
  };
  PassMachine one(config, scene.volume.blocks()), other(config, scene.volume.blocks());
  const Frame first = run(one, 1), second = run(one, 1);
  EXPECT_EQ(run(other, 3).cycles, first.cycles);
  EXPECT_EQ(second.all_cycles, first.cycles + second.cycles);
  EXPECT_GT(first.reads, 0u);
  EXPECT_EQ(second.reads, 0u);
  one.invalidate_caches();
  EXPECT_EQ(run(one, 1).reads, first.reads);
}

// Latencies between the parts stand in asic/latencies.h, for both levels: a ray that meets no other takes the same cycles.
TEST(PassMachine, TakesALoneRayToItsEndInAsManyCyclesAsTheCycleLevel) {
  struct Way {
    std::string name;
    std::vector<std::string> machine;
    std::array<double, 3> from, along;
  };
  const std::vector<Way> ways{
      {"one sample", {"asic.processors=1"}, {4.5, 4.5, 31.5}, {0, 0, 1}},
      {"two samples", {"asic.processors=1"}, {4.5, 4.5, 30.5}, {0, 0, 1}},
      {"through two blocks", {"asic.processors=1"}, {4.5, 4.5, 3.5}, {0, 0, 1}},
      {"over a link", {"asic.processors=2"}, {4.5, 4.5, 10.5}, {1, 0, 0}},
      {"over three links", {"asic.processors=4", "asic.partition=skewed_block"}, {1.5, 4.5, 10.5}, {1, 0.2, 0.1}},
  };
  for (const Way& way : ways) {
    std::vector<std::string> assignments = way.machine;
    assignments.insert(assignments.end(), {"ideal.memory=1", "ideal.dsp=1", "asic.block_voxels=16"});
    const v1::BoardConfig config = config_with(assignments);
    Scene scene({33, 33, 33}, kBlock);
    std::vector<wire::Ray> cycle_rays{host_ray(0, way.from, way.along)}, pass_rays = cycle_rays;
    Machine machine(config, scene.volume.blocks());
    const RunResult expected = trace_cycle(cycle_rays, scene.frame, machine);

    PassMachine passes(config, scene.volume.blocks());
    HostRays source(pass_rays, scene.frame, true);
    TracedPasses traced(source, {0, 1}, scene.frame, nullptr, 1);
    Progress progress;
    EXPECT_EQ(passes.run(traced, scene.frame, progress, false).cycles, expected.cycles) << way.name;
    EXPECT_EQ(pass_rays, cycle_rays) << way.name;
  }
}

// The block in which the first ray ended is still active when the second begins there. Which packets that one needs shows its way.
TEST(PassMachine, DrawsStepsByPlacesInTheVolumeAlsoInABlockThatWasActiveWithoutJitter) {
  const v1::BoardConfig config = config_with({"asic.processors=1", "ideal.dsp=1", "asic.block_voxels=16"});
  Scene scene({49, 49, 49}, kBlock);
  Machine machine(config, scene.volume.blocks());
  PassMachine passes(config, scene.volume.blocks());
  const std::vector<wire::Ray> straight{host_ray(0, {20.5, 20.5, 28.5}, {0, 0, -1})},
      jittered{host_ray(77, {20.5, 20.5, 1.5}, {0.4, 0.3, 1})};
  for (const bool jitter : {false, true}) {
    std::vector<wire::Ray> cycle_rays = jitter ? jittered : straight, pass_rays = cycle_rays;
    scene.frame.jitter = jitter;
    trace_cycle(cycle_rays, scene.frame, machine);
    HostRays source(pass_rays, scene.frame, true);
    TracedPasses traced(source, {0, 1}, scene.frame, nullptr, 1);
    Progress progress;
    passes.run(traced, scene.frame, progress, false);
    std::vector<wire::Counter> list;
    passes.count(list);
    EXPECT_EQ(value(list, "rdram.reads"), machine.memories()[0]->channel().counters().packets_read) << jitter;
  }
}

TEST(PassMachine, EndsWhenItIsCancelled) {
  Scene scene({kEdge, kEdge, kEdge}, kBlock);
  set_up(scene, {});
  const v1::BoardConfig config = config_with({"asic.block_voxels=16", "asic.max_volume_voxels=128"});
  PassMachine machine(config, scene.volume.blocks());
  Framebuffer framebuffer;
  Progress work;
  work.cancel = true;
  const wire::RenderCommand view = corner_view({kEdge, kEdge, kEdge}, 48);
  ImageRays source(view, scene.frame, framebuffer);
  TracedPasses passes(source, {0, source.count()}, scene.frame, nullptr, 1);
  EXPECT_TRUE(machine.run(passes, scene.frame, work, false).cancelled);
}

}  // namespace
}  // namespace gicube::emu
