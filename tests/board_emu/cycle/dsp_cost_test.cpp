// What rays cost the DSP and the memories in hand-worked sums: one cycle more or less of it fails.
#include "bare_board.h"
#include "cycle/machine.h"
#include "firmware/framebuffer.h"
#include "firmware/ray_sources/image_rays.h"
#include "firmware/ray_sources/light_rays.h"
#include "lighting_rig.h"
#include "machine_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kImage = 32;  // pixels an edge
v1::BoardConfig with_small_blocks(std::vector<std::string> more) {
  more.push_back("asic.block_voxels=8");
  return config_with(more);
}

struct Rendered {
  explicit Rendered(const std::vector<std::string>& more)
      : config(with_small_blocks(more)), scene({33, 33, 33}, 8), machine(config, scene.volume.blocks()) {
    ran = cycle_picture(scene, corner_view({33, 33, 33}, kImage), machine, runs_of(config)).ran;
  }
  v1::BoardConfig config;
  Scene scene;
  Machine machine;
  RunResult ran;
};

constexpr std::uint64_t kRow = kBeginRow.setup() + kBeginRow.interval();

// Of all that the DSP computes, what it takes to change loops is left, whichever they were.
std::uint64_t changes(const Dsp& dsp, std::uint64_t of_loops) { return dsp.counters().compute - of_loops; }

TEST(DspCost, IsThatOfMakingEachPixelsRayAndOfTakingBackThoseThatWereSent) {
  const Rendered frame({});
  const RayEngineCounters& engine = frame.machine.dsp().counters();
  const Dsp& dsp = frame.machine.dsp().dsp();
  ASSERT_EQ(engine.overflows, 0u);
  ASSERT_GT(engine.taken, 100u);
  EXPECT_EQ(engine.sent, engine.taken);
  const std::uint64_t rest = changes(
      dsp, kImage * kImage * kMakeViewingRay.interval() + kImage * kRow + engine.taken * kStorePixel.interval());
  const std::uint64_t to_pixels = dsp.counters().loops / 2,
                      to_rays = dsp.counters().loops - to_pixels;  // in turns, rays first
  EXPECT_EQ(rest, to_rays * kMakeViewingRay.setup() + to_pixels * kStorePixel.setup());
  EXPECT_EQ(frame.ran.dsp_cycles, dsp.counters().busy());
  EXPECT_EQ(dsp.memory().counters().packets_written, engine.taken) << "a finished pixel is one burst";
}

TEST(DspCost, OfChangingLoopsIsLessThanAQuarterWhereItHasAllTheWork) {
  const Rendered frame({"asic.processors=16"});
  const Dsp& dsp = frame.machine.dsp().dsp();
  const std::uint64_t loops =
      kImage * kImage * kMakeViewingRay.interval() + frame.machine.dsp().counters().taken * kStorePixel.interval();
  EXPECT_LT(changes(dsp, loops + kImage * kRow), dsp.counters().compute / 4);
}

TEST(DspCost, OfAnOverflowedRayIsPaidForKeepingItForItsSlotAndForSendingItAgain) {
  const Rendered frame({"asic.queue_rays=2", "asic.processors=1"});
  const RayEngineCounters& engine = frame.machine.dsp().counters();
  ASSERT_GT(engine.overflows, 100u);
  EXPECT_EQ(engine.sent, engine.taken + engine.overflows);
  EXPECT_EQ(frame.machine.processors()[0]->sorter().counters().reserved_slots, engine.overflows);
  EXPECT_GT(frame.ran.dsp_cycles, engine.overflows * 2 * kStoreRay.interval());
}

TEST(DspCost, OfARunIsPaidOnceForAllItsRays) {
  const Rendered frame({"dsp.run_rays=12", "dsp.run_error=16384"});
  const RayEngineCounters& engine = frame.machine.dsp().counters();
  const Dsp& dsp = frame.machine.dsp().dsp();
  ASSERT_EQ(engine.overflows, 0u);
  Framebuffer framebuffer;
  const wire::RenderCommand view = corner_view({33, 33, 33}, kImage);
  const ImageRays rays(view, frame.scene.frame, framebuffer, runs_of(frame.config));
  std::uint64_t cycles = 0, made = 0;
  for (std::uint64_t i = 0; i < rays.count(); i = rays.run_end(i), ++made) cycles += rays.making(i).cycles();
  ASSERT_LT(made, rays.count() / 2);
  const std::uint64_t rest = changes(dsp, cycles + engine.taken * kStorePixel.interval()),
                      changes = dsp.counters().loops;
  EXPECT_GE(rest, changes / 2 * (kMakeViewingRay.setup() + kStorePixel.setup()));
  EXPECT_LE(rest, (changes / 2 + 1) * (kMakeRun.setup() + kStorePixel.setup()) + made * kMakeRun.setup());
}

TEST(DspCost, OfHostRaysIsPaidOnTheWayInAndOnTheWayBack) {
  const v1::BoardConfig config = with_small_blocks({});
  Scene scene({33, 33, 33}, 8);
  Machine machine(config, scene.volume.blocks());
  std::vector<wire::Ray> rays;
  for (std::uint32_t i = 0; i < 30; ++i) rays.push_back(host_ray(i, {i + 0.5, 4.5, 20.5}, {0, 0, 1}));
  trace_cycle(rays, scene.frame, machine);
  const DspCounters& dsp = machine.dsp().dsp().counters();
  EXPECT_EQ(dsp.compute, 2u * 30 * kPassRay.interval() + kPassRay.setup()) << "one loop does both";
  EXPECT_EQ(machine.dsp().dsp().memory().counters().packets_read, 30u + (kPassRay.code_bytes() + 31) / 32);
}

TEST(DspCost, OfALightingRayIsPaidForThoseThatHaveEnergyAndNothingWhenTheyEnd) {
  LitScene lit({17, 17, 17}, 8, false);
  lit.medium(0.1, 0, wire::Bsdf::kNone);
  lit.scene.set_depths();
  const v1::BoardConfig config = with_small_blocks({"asic.queue_rays=4096"});
  Machine machine(config, lit.scene.volume.blocks());
  const wire::IlluminateCommand command = light_of(wire::LightKind::kPoint, 40'000, {8, 8, 8}, 1);
  const LightingRays maker = lit.rays(command);
  LightRays source(maker, lit.scene.frame);
  Progress progress;
  machine.run(source, lit.scene.frame, progress);
  const RayEngineCounters& engine = machine.dsp().counters();
  ASSERT_GT(engine.sent, 500u);
  ASSERT_EQ(engine.overflows, 0u);
  EXPECT_EQ(machine.dsp().dsp().counters().compute,
            kMakeLightingRay.setup() + engine.sent * kMakeLightingRay.interval());
}

// Where no order of them is known.
TEST(DspCost, OfTheFunctionalLevelIsThatWithoutWaitsAndWithEachLoopBegunOnce) {
  const Rendered frame({});
  Framebuffer framebuffer;
  const wire::RenderCommand view = corner_view({33, 33, 33}, kImage);
  ImageRays rays(view, frame.scene.frame, framebuffer);
  const std::uint64_t taken = frame.machine.dsp().counters().taken;
  EXPECT_EQ(run_functional(rays, frame.scene.frame).dsp_cycles,
            kMakeViewingRay.setup() + kImage * kImage * kMakeViewingRay.interval() + kImage * kRow +
                kStorePixel.setup() + taken * kStorePixel.interval());
}

TEST(DspCost, IsNothingOfAnIdealDspAtAllLevels) {
  const Rendered frame({"ideal.dsp=1"});
  EXPECT_EQ(frame.ran.dsp_cycles, 0u);
  EXPECT_EQ(frame.machine.dsp().dsp().memory().counters().packets_read, 0u);
  EXPECT_LT(frame.ran.cycles, Rendered({}).ran.cycles);
}

std::uint64_t lone_ray_cycles(const std::vector<std::string>& assignments, int samples) {
  std::vector<std::string> all{"asic.processors=1", "asic.block_voxels=32", "ideal.dsp=1"};
  all.insert(all.end(), assignments.begin(), assignments.end());
  const v1::BoardConfig config = config_with(all);
  Scene scene({33, 33, 33}, 32);
  Machine machine(config, scene.volume.blocks());
  std::vector<wire::Ray> rays{host_ray(0, {4.5, 4.5, 33 - samples - 0.5}, {0, 0, 1})};
  return trace_cycle(rays, scene.frame, machine).cycles;
}

// As machine_test counts them: 5 to the tag check, turns of both parts' stages and three cycles, and 3 back to the
// DSP's end.
TEST(PipelineCost, IsBothPartsStagesAndThreeCyclesAPass) {
  for (const auto& [prefetch, compute] : {std::pair(16, 16), std::pair(3, 5), std::pair(7, 1), std::pair(1, 9)}) {
    for (const int samples : {1, 2, 6}) {
      EXPECT_EQ(lone_ray_cycles({"ideal.memory=1", "pipeline.prefetch_stages=" + std::to_string(prefetch),
                                 "pipeline.compute_stages=" + std::to_string(compute)},
                                samples),
                static_cast<unsigned>(1 + 4 + (prefetch + compute + 3) * (samples - 1) + prefetch + compute + 2 + 1));
    }
  }
}

// A lone ray's cold packets with nothing else on the wires: what each step takes longer, the ray takes longer, to the
// cycle. One prefetch stage hides nothing.
TEST(MemoryCost, OfEachStepOfAColdReadIsPaidToTheCycle) {
  const std::vector<std::string> base{"rdram.refresh_interval=0", "pipeline.prefetch_stages=1"};
  const auto with = [&base](const std::string& more) {
    std::vector<std::string> all = base;
    all.push_back(more);
    return lone_ray_cycles(all, 1);
  };
  const std::uint64_t usual = lone_ray_cycles(base, 1);
  // Four tCYCLE are a core cycle.
  EXPECT_EQ(with("rdram.t_rcd=11"), usual + 1);
  EXPECT_EQ(with("rdram.t_cac=12"), usual + 1);
  EXPECT_EQ(with("rdram.rac_latency=8"), usual + 1);
  EXPECT_EQ(with("rdram.t_rcd=27"), usual + 5);
  EXPECT_EQ(with("rdram.t_rp=100"), usual) << "nothing is precharged";
}

TEST(MemoryCost, OfEachStepOfAColdDdrReadIsPaidToTheCycle) {
  const std::vector<std::string> base{"memory=ddr", "ddr.refresh_interval=0", "pipeline.prefetch_stages=1"};
  const auto with = [&base](const std::string& more) {
    std::vector<std::string> all = base;
    all.push_back(more);
    return lone_ray_cycles(all, 1);
  };
  const std::uint64_t usual = lone_ray_cycles(base, 1);
  EXPECT_EQ(with("ddr.t_rcd=3"), usual + 1);
  EXPECT_EQ(with("ddr.t_cl=3"), usual + 1);
  EXPECT_EQ(with("ddr.controller_latency=2"), usual + 1);
  EXPECT_EQ(with("ddr.t_rp=50"), usual) << "nothing is precharged";
}

}  // namespace
}  // namespace gicube::emu
