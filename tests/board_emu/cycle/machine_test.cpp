// Hand-worked cycles of whole rays through the machine.
#include "cycle/machine.h"

#include "bare_board.h"
#include "firmware/ray_sources/image_rays.h"
#include "machine_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

std::uint64_t cycles(const Machine& machine, Cause cause, std::size_t processor = 0) {
  return machine.processors()[processor]->causes()[static_cast<std::size_t>(cause)];
}

// Rays along z, one a voxel column of the block at the origin, samples at cell centres.
std::vector<wire::Ray> columns(int across, int down, double start = 0.5) {
  std::vector<wire::Ray> rays;
  for (int y = 0; y < down; ++y) {
    for (int x = 0; x < across; ++x) {
      rays.push_back(host_ray(static_cast<std::uint32_t>(rays.size()), {x + 0.5, y + 0.5, start}, {0, 0, 1}));
    }
  }
  return rays;
}

RunResult run(Machine& machine, const Scene& scene, std::vector<wire::Ray> rays) {
  return trace_cycle(rays, scene.frame, machine);
}

// 0: the DSP makes the ray; push 1; bus 2; sorter writes 3, issues 4; tag check 5. 16 + 16 stages; back at the sorter
// 38, issued 39, next tag check 40: 35 cycles a turn. After the last turn's 32 stages: tree 33, DSP 34, and a cycle
// more.
TEST(Machine, ALoneRayTakesThirtyFiveCyclesASampleWithPerfectMemory) {
  const v1::BoardConfig config =
      config_with({"asic.processors=1", "ideal.memory=1", "ideal.dsp=1", "asic.block_voxels=32"});
  for (const int samples : {1, 2, 7}) {
    Scene scene({33, 33, 33}, 32);
    Machine machine(config, scene.volume.blocks());
    const RunResult ran = run(machine, scene, {host_ray(0, {4.5, 4.5, 33 - samples - 0.5}, {0, 0, 1})});
    EXPECT_EQ(ran.cycles, 1u + 4 + 35 * static_cast<unsigned>(samples - 1) + 34 + 1) << samples;
    EXPECT_EQ(cycles(machine, Cause::kBusy), static_cast<unsigned>(samples));
  }
}

TEST(Machine, FewerRaysThanATurnHasCyclesLeaveThePipelineWaitingAndMoreDoNot) {
  const v1::BoardConfig config =
      config_with({"asic.processors=1", "ideal.memory=1", "ideal.dsp=1", "asic.block_voxels=32"});
  Scene scene({33, 33, 33}, 32);
  Machine few(config, scene.volume.blocks());
  run(few, scene, columns(16, 1));
  EXPECT_EQ(cycles(few, Cause::kBusy), 16u * 32);
  // A turn takes 35 cycles and brings 16 samples; the first and the last are longer.
  EXPECT_GE(few.now(), 32u * 35);
  EXPECT_GT(cycles(few, Cause::kLatency), 31u * (35 - 16) * 9 / 10);
  Machine many(config, scene.volume.blocks());
  run(many, scene, columns(32, 4));
  EXPECT_EQ(cycles(many, Cause::kBusy), 32u * 32 * 4);
  EXPECT_LT(cycles(many, Cause::kLatency) + cycles(many, Cause::kSorter), 32u * 32 * 4 / 8);
}

TEST(Machine, ABlockAtOneSampleAVoxelIsFetchedOnce) {
  for (const unsigned n : {8u, 16u, 32u}) {
    const v1::BoardConfig config =
        config_with({"asic.processors=1", "asic.block_voxels=" + std::to_string(n), "asic.queue_rays=64"});
    const int edge = static_cast<int>(n) + 1;
    Scene scene({edge, edge, edge}, static_cast<int>(n));
    Machine machine(config, scene.volume.blocks());
    run(machine, scene, columns(static_cast<int>(n), static_cast<int>(n)));
    const CacheCounters& cache = machine.processors()[0]->cache().counters();
    EXPECT_EQ(cache.checks, n * n * n);
    EXPECT_EQ(cache.filled_voxels, (n + 1) * (n + 1) * (n + 1));
    EXPECT_EQ(machine.memories()[0]->channel().counters().packets_read, (n / 2 + 1) * (n / 2 + 1) * (n + 1));
    EXPECT_EQ(cycles(machine, Cause::kBusy), n * n * n);
  }
}

TEST(Machine, CachesStayWarmFromCommandToCommandUntilTheVolumeChanges) {
  const v1::BoardConfig config = config_with({"asic.processors=1", "asic.block_voxels=16"});
  Scene scene({17, 17, 17}, 16);
  Machine machine(config, scene.volume.blocks());
  const auto packets = [&] { return machine.processors()[0]->cache().counters().packets; };
  run(machine, scene, columns(16, 16));
  const std::uint64_t cold = packets();
  run(machine, scene, columns(16, 16));
  EXPECT_EQ(packets(), cold);
  machine.invalidate_caches();
  run(machine, scene, columns(16, 16));
  EXPECT_EQ(packets(), 2 * cold);
}

TEST(Machine, LeapingRaysTakeOneCycleABlockAndNoMemory) {
  const v1::BoardConfig config = config_with({"asic.processors=2", "asic.block_voxels=16"});
  Scene scene({64, 64, 64}, 16);
  scene.frame.skip_empty = true;
  std::fill(scene.frame.empty.begin(), scene.frame.empty.end(), std::uint8_t{1});
  Machine machine(config, scene.volume.blocks());
  run(machine, scene, columns(20, 1));
  EXPECT_EQ(cycles(machine, Cause::kLeap), 20u * 4);
  EXPECT_EQ(cycles(machine, Cause::kBusy), 0u);
  EXPECT_EQ(machine.memories()[0]->channel().counters().packets_read, 0u);
}

TEST(Machine, SlabsPassRaysToTheNeighbourAndOnlyToIt) {
  const v1::BoardConfig config = config_with({"asic.processors=4", "asic.block_voxels=8"});
  Scene scene({64, 64, 64}, 8);
  Machine machine(config, scene.volume.blocks());
  std::vector<wire::Ray> rays;
  for (unsigned i = 0; i < 30; ++i) rays.push_back(host_ray(i, {0.5, i + 1.5, 20.5}, {1, 0, 0}));
  run(machine, scene, rays);
  for (std::uint32_t p = 0; p < 4; ++p) {
    EXPECT_EQ(machine.links().counters(p).sent, p < 3 ? 30u : 0u);
    EXPECT_EQ(machine.links().counters(p).hops(), p < 3 ? 30u : 0u);
  }
  EXPECT_EQ(machine.links().bisection_rays(), 30u);
}

TEST(Machine, AQueueOfOneRayOverflowsAndStillFinishesEveryRay) {
  const v1::BoardConfig config =
      config_with({"asic.processors=1", "asic.block_voxels=16", "asic.queue_rays=1", "ideal.dsp=1"});
  Scene scene({17, 17, 17}, 16);
  Machine machine(config, scene.volume.blocks());
  run(machine, scene, columns(16, 16));
  EXPECT_EQ(machine.dsp().counters().taken, 256u);
  EXPECT_GT(machine.dsp().counters().overflows, 0u);
  EXPECT_EQ(machine.processors()[0]->sorter().counters().overflows, machine.dsp().counters().overflows);
}

// With nothing to hide the latency, one ray waits for each packet: the causes say so, and each cycle has one.
TEST(Machine, CausesOfALoneRayInColdMemoryAreMissesAndFills) {
  const v1::BoardConfig config =
      config_with({"asic.processors=1", "rdram.refresh_interval=0", "pipeline.prefetch_stages=1"});
  Scene scene({33, 33, 33}, 32);
  Machine machine(config, scene.volume.blocks());
  run(machine, scene, {host_ray(0, {4.5, 4.5, 30.5}, {0, 0, 1})});
  EXPECT_EQ(cycles(machine, Cause::kBusy), 2u);
  EXPECT_EQ(cycles(machine, Cause::kFill), 1u);  // two packets for the first sample, one for the second
  EXPECT_GT(cycles(machine, Cause::kMiss) + cycles(machine, Cause::kBank), 6u);
  EXPECT_EQ(cycles(machine, Cause::kRefresh), 0u);
  const CauseCounts& causes = machine.processors()[0]->causes();
  EXPECT_EQ(std::accumulate(causes.begin(), causes.end(), std::uint64_t{0}), machine.now());
}

// At odd x and y the first sample needs eight packets, and each further one the four of a slice. All have come before
// it leaves the prefetch line, so with one port it stands still for all but the last, and with two not at all.
TEST(Machine, WithTwoPortsPacketsThatHaveComeHoldNoSampleUp) {
  for (const int samples : {1, 2, 5}) {
    Scene scene({33, 33, 33}, 32);
    std::uint64_t took[2] = {0, 0};
    for (const unsigned ports : {1u, 2u}) {
      const v1::BoardConfig config =
          config_with({"asic.processors=1", "rdram.refresh_interval=0", "ideal.dsp=1", "pipeline.prefetch_stages=100",
                       "cache.ports=" + std::to_string(ports)});
      Machine machine(config, scene.volume.blocks());
      took[ports - 1] = run(machine, scene, {host_ray(0, {5.5, 5.5, 33 - samples - 0.5}, {0, 0, 1})}).cycles;
      EXPECT_EQ(cycles(machine, Cause::kBusy), static_cast<unsigned>(samples));
      EXPECT_EQ(cycles(machine, Cause::kFill), ports == 1 ? 7u + 3 * static_cast<unsigned>(samples - 1) : 0u);
      EXPECT_EQ(machine.memories()[0]->channel().counters().packets_read, 8u + 4 * static_cast<unsigned>(samples - 1));
    }
    EXPECT_EQ(took[0] - took[1], 7u + 3 * static_cast<unsigned>(samples - 1)) << samples;
  }
}

// The second block's packets would take the places of the first's, whose last samples are still in the prefetch line.
TEST(Machine, WithTwoPortsAPacketWaitsForOlderSamplesOfAnotherBlock) {
  const auto fills = [](bool of_one_block) {
    Scene scene({64, 33, 33}, 32);
    const v1::BoardConfig config = config_with({"asic.processors=1", "rdram.refresh_interval=0", "ideal.dsp=1",
                                                "pipeline.prefetch_stages=100", "cache.ports=2"});
    Machine machine(config, scene.volume.blocks());
    const double x = of_one_block ? 9.5 : 37.5;
    run(machine, scene, {host_ray(0, {5.5, 5.5, 31.5}, {0, 0, 1}), host_ray(1, {x, 5.5, 31.5}, {0, 0, 1})});
    return cycles(machine, Cause::kFill);
  };
  EXPECT_EQ(fills(true), 0u);
  EXPECT_GE(fills(false), 6u);
}

// Passes on what another source makes, and notes how many of its rays are under way.
class FewUnderWay : public HostRays {
 public:
  FewUnderWay(std::span<wire::Ray> rays, const Frame& frame, std::uint64_t most)
      : HostRays(rays, frame, true), most_(most) {}
  std::uint64_t max_under_way() const override { return most_; }
  std::optional<wire::Ray> make(std::uint64_t i, RayCounters& counters) override {
    seen = std::max(seen, ++under_way_);
    return HostRays::make(i, counters);
  }
  void take(std::uint64_t i, const wire::Ray& ray) override {
    --under_way_;
    HostRays::take(i, ray);
  }
  std::uint64_t seen = 0;

 private:
  std::uint64_t most_, under_way_ = 0;
};

TEST(Machine, HasNoMoreRaysUnderWayThanTheirSourceAndTheOverflowStoreAllow) {
  Scene scene({33, 33, 33}, 32);
  for (const auto& [of_source, places] : {std::pair{5u, 65'536u}, {100u, 7u}}) {
    const v1::BoardConfig config =
        config_with({"asic.processors=1", "ideal.dsp=1", "dsp.overflow_rays=" + std::to_string(places)});
    Machine machine(config, scene.volume.blocks());
    std::vector<wire::Ray> rays = columns(16, 8);
    FewUnderWay source(rays, scene.frame, of_source);
    Progress progress;
    machine.run(source, scene.frame, progress);
    EXPECT_EQ(source.seen, std::min(of_source, places));
    EXPECT_EQ(machine.dsp().counters().taken, 128u);
  }
}

TEST(Machine, RunsOfRaysTakeLessOfTheDsp) {
  Scene scene({33, 33, 33}, 8);
  scene.fill([](int x, int y, int z) { return wire::Voxel{static_cast<std::uint16_t>(x * y * z % 4096), 0, 0, 0}; });
  for (auto& entry : scene.segmentation) entry.opacity = 900;
  const auto picture = [&](const char* run_rays) {
    const v1::BoardConfig config = config_with({"asic.block_voxels=8", run_rays});
    Machine machine(config, scene.volume.blocks());
    return cycle_picture(scene, corner_view({33, 33, 33}, 64), machine, runs_of(config));
  };
  const Picture one_by_one = picture("dsp.run_rays=0"), in_runs = picture("dsp.run_rays=16");
  EXPECT_LT(in_runs.ran.dsp_cycles, one_by_one.ran.dsp_cycles * 4 / 5) << "taking rays back costs the same";
}

TEST(Machine, CancellingStopsWithinTheProgressInterval) {
  const v1::BoardConfig config = config_with({"asic.block_voxels=16"});
  Scene scene({64, 64, 64}, 16);
  Machine machine(config, scene.volume.blocks());
  Framebuffer framebuffer;
  Progress work;
  work.cancel = true;
  const wire::RenderCommand view = corner_view({64, 64, 64}, 128);
  ImageRays rays(view, scene.frame, framebuffer);
  const RunResult ran = machine.run(rays, scene.frame, work);
  EXPECT_TRUE(ran.cancelled);
  EXPECT_LE(ran.cycles, 3 * 4096u);
}

// Looks at the machine every so many cycles, and that each look keeps what the parts have.
class Looker : public Observer {
 public:
  void see(Cycle now, const Machine& machine) override {
    if (now % 257 != 0) return;
    const MachineLook seen = look(machine);
    ASSERT_EQ(seen.cells, (std::array<std::uint32_t, 3>{4, 4, 4}));
    ASSERT_EQ(seen.waiting.size(), 64u);
    std::uint64_t waiting = 0;
    for (std::size_t i = 0; i < machine.processors().size(); ++i) {
      EXPECT_EQ(seen.processors.at(i), machine.processors()[i]->sorter().waiting());
      waiting += seen.processors.at(i);
    }
    EXPECT_EQ(std::accumulate(seen.waiting.begin(), seen.waiting.end(), std::uint64_t{0}), waiting);
    for (std::size_t i = 0; i < machine.memories().size(); ++i) {
      const auto& packets = seen.packets.at(i);
      const dram::ChannelCounters counters = machine.memories()[i]->channel().counters();
      EXPECT_EQ(packets.size(), std::size_t{machine.memories()[i]->devices()} * seen.banks);
      EXPECT_EQ(std::accumulate(packets.begin(), packets.end(), std::uint64_t{0}),
                counters.packets_read + counters.packets_written);
    }
    most_waiting = std::max(most_waiting, waiting);
    ++looks;
  }

  std::uint64_t most_waiting = 0;
  int looks = 0;
};

TEST(Machine, ALookHasEveryWaitingRayInABlockAndEveryPacketInABank) {
  for (const char* memory : {"memory=rdram", "memory=ddr"}) {
    const v1::BoardConfig config = config_with({"asic.block_voxels=16", memory});
    Scene scene({64, 64, 64}, 16);
    Machine machine(config, scene.volume.blocks());
    Looker looker;
    machine.set_observer(&looker);
    cycle_picture(scene, corner_view({64, 64, 64}, 32), machine);
    EXPECT_GT(looker.looks, 20) << memory;
    EXPECT_GT(looker.most_waiting, 100u) << memory;
    EXPECT_EQ(look(machine).banks, memory == std::string("memory=rdram") ? 32u : 4u);
  }
}

// Rays that begin in one block, where the first is still in the pipeline when the others wait.
TEST(Machine, ALookShowsRaysInTheBlockInWhichTheyWait) {
  const v1::BoardConfig config = config_with({"asic.processors=2", "asic.block_voxels=16", "ideal.dsp=1"});
  Scene scene({64, 64, 64}, 16);
  Machine machine(config, scene.volume.blocks());
  struct First : Observer {
    void see(Cycle, const Machine& seen) override {
      if (std::ranges::count(at.waiting, 0u) == std::ranges::ssize(at.waiting)) at = look(seen);
    }
    MachineLook at;
  } first;
  machine.set_observer(&first);
  std::vector<wire::Ray> rays;
  for (unsigned i = 0; i < 8; ++i) rays.push_back(host_ray(i, {i + 16.5, 32.5, 48.5}, {0, 0, 1}));
  run(machine, scene, rays);
  std::vector<std::uint32_t> expected(64);
  expected[1 + 4 * (2 + 4 * 3)] = 1;  // the first that is sorted in
  EXPECT_EQ(first.at.waiting, expected);
  EXPECT_EQ(first.at.processors, (std::vector<std::uint32_t>{1, 0}));
}

TEST(Machine, ALookAtASingleQueueHasNoBlocksAndOneAtVeryManyBlocksHasCubesOfThem) {
  const Machine single(config_with({"sorter.queues=single"}), {2, 2, 2});
  EXPECT_TRUE(look(single).waiting.empty());
  EXPECT_EQ(look(single).processors.size(), single.processors().size());
  const Machine large(config_with({"asic.block_voxels=8"}), {41, 41, 41});  // 68,921
  EXPECT_EQ(look(large).blocks_a_side, 2u);
  EXPECT_EQ(look(large).cells, (std::array<std::uint32_t, 3>{21, 21, 21}));
  EXPECT_EQ(look(large).waiting.size(), 21u * 21 * 21);
}

// Takes the first ray off the bus's end: a ray that is lost.
class Thief : public Observer {
 public:
  explicit Thief(Processor& processor) : processor_(processor) {}
  void see(Cycle now, const Machine&) override {
    if (!stolen_ && processor_.from_bus.can_pop(now + 1)) {
      processor_.from_bus.pop(now + 1);
      stolen_ = true;
    }
  }

 private:
  Processor& processor_;
  bool stolen_ = false;
};

TEST(Machine, StopsWithADescriptionOfEveryPartWhenNothingMoves) {
  const v1::BoardConfig config = config_with({"asic.processors=1", "asic.block_voxels=16"});
  Scene scene({17, 17, 17}, 16);
  Machine machine(config, scene.volume.blocks());
  Thief thief(*machine.processors()[0]);
  machine.set_observer(&thief);
  try {
    run(machine, scene, columns(4, 1));
    FAIL() << "a ray is lost: the machine can't come to an end";
  } catch (const Stall& stall) {
    EXPECT_THAT(stall.what(), HasSubstr("1 rays under way"));
    EXPECT_THAT(stall.what(), HasSubstr("processor 0"));
  }
  EXPECT_LE(machine.now(), Machine::kStallCycles + 2000);
}

}  // namespace
}  // namespace gicube::emu
