// Each cost of the configuration in hand-worked sums: one cycle more or less of it fails.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bare_board.h"
#include "cycle/machine.h"
#include "firmware/framebuffer.h"
#include "firmware/ray_sources/image_rays.h"
#include "firmware/ray_sources/light_rays.h"
#include "lighting_rig.h"
#include "machine_rig.h"

namespace gicube::emu {
namespace {

constexpr int kImage = 32;  // pixels an edge
// Odd, so that a half that is rounded the wrong way shows.
const std::vector<std::string> kOddCosts{"dsp.viewing_ray_cycles=17",  "dsp.returned_ray_cycles=7",
                                         "dsp.overflow_ray_cycles=13", "dsp.run_cycles=41",
                                         "dsp.lighting_ray_cycles=61", "asic.block_voxels=8"};

v1::BoardConfig costs(const std::vector<std::string>& more) {
  std::vector<std::string> all = kOddCosts;
  all.insert(all.end(), more.begin(), more.end());
  return config_with(all);
}

struct Rendered {
  explicit Rendered(const std::vector<std::string>& more)
      : config(costs(more)), scene({33, 33, 33}, 8), machine(config, scene.volume.blocks()) {
    ran = cycle_picture(scene, corner_view({33, 33, 33}, kImage), config, machine).ran;
  }
  v1::BoardConfig config;
  Scene scene;
  Machine machine;
  RunResult ran;
};

TEST(DspCost, IsThatOfMakingEachPixelsRayAndOfTakingBackThoseThatWereSent) {
  const Rendered frame({});
  const RayEngineCounters& dsp = frame.machine.dsp().counters();
  ASSERT_EQ(dsp.overflows, 0u);
  ASSERT_GT(dsp.taken, 100u);
  EXPECT_EQ(dsp.sent, dsp.taken);
  EXPECT_EQ(frame.ran.dsp_cycles, 17 * kImage * kImage + 7 * dsp.taken);
}

TEST(DspCost, OfAnOverflowedRayIsPaidOnceEachTimeThatItIsSentAgain) {
  const Rendered frame({"asic.queue_rays=2"});
  const RayEngineCounters& dsp = frame.machine.dsp().counters();
  ASSERT_GT(dsp.overflows, 100u);
  EXPECT_EQ(dsp.sent, dsp.taken + dsp.overflows);
  EXPECT_EQ(frame.ran.dsp_cycles, 17 * kImage * kImage + 7 * dsp.taken + 13 * dsp.overflows);
}

TEST(DspCost, OfARunIsPaidOnceForAllItsRays) {
  const Rendered frame({"dsp.run_rays=12"});
  const RayEngineCounters& dsp = frame.machine.dsp().counters();
  ASSERT_EQ(dsp.overflows, 0u);
  EXPECT_EQ(frame.ran.dsp_cycles, 41 * 3 * kImage + 7 * dsp.taken);  // rows of 12, 12 and 8
}

TEST(DspCost, OfHostRaysIsPaidOnTheWayInAndOnTheWayBack) {
  const v1::BoardConfig config = costs({});
  Scene scene({33, 33, 33}, 8);
  Machine machine(config, scene.volume.blocks());
  std::vector<wire::Ray> rays;
  for (std::uint32_t i = 0; i < 30; ++i) rays.push_back(host_ray(i, {i + 0.5, 4.5, 20.5}, {0, 0, 1}));
  EXPECT_EQ(trace_cycle(rays, scene.frame, machine, {5, 6}).dsp_cycles, 30u * (5 + 6));
}

TEST(DspCost, OfALightingRayIsPaidForThoseThatHaveEnergyAndNothingWhenTheyEnd) {
  LitScene lit({17, 17, 17}, 8, false);
  lit.medium(0.1, 0, wire::Bsdf::kNone);
  lit.scene.set_depths();
  const v1::BoardConfig config = costs({});
  Machine machine(config, lit.scene.volume.blocks());
  const wire::IlluminateCommand command = light_of(wire::LightKind::kPoint, 40'000, {8, 8, 8}, 1);
  const LightingRays maker = lit.rays(command);
  LightRays source(maker, lit.scene.frame, config.dsp());
  Progress progress;
  const RunResult ran = machine.run(source, lit.scene.frame, progress);
  const RayEngineCounters& dsp = machine.dsp().counters();
  ASSERT_GT(dsp.sent, 500u);
  EXPECT_EQ(ran.dsp_cycles, 61 * (dsp.sent - dsp.overflows) + 13 * dsp.overflows);
}

// The functional level's: without overflows, which it does not have.
TEST(DspCost, OfTheFunctionalLevelIsTheSameWhereNothingOverflows) {
  const Rendered frame({});
  Framebuffer framebuffer;
  const wire::RenderCommand view = corner_view({33, 33, 33}, kImage);
  ImageRays rays(view, frame.scene.frame, framebuffer, frame.config.dsp());
  EXPECT_EQ(run_functional(rays, frame.scene.frame).dsp_cycles, frame.ran.dsp_cycles);
}

std::uint64_t lone_ray_cycles(const std::vector<std::string>& assignments, int samples) {
  std::vector<std::string> all{"asic.processors=1", "asic.block_voxels=32"};
  all.insert(all.end(), assignments.begin(), assignments.end());
  const v1::BoardConfig config = config_with(all);
  Scene scene({33, 33, 33}, 32);
  Machine machine(config, scene.volume.blocks());
  std::vector<wire::Ray> rays{host_ray(0, {4.5, 4.5, 33 - samples - 0.5}, {0, 0, 1})};
  return trace_cycle(rays, scene.frame, machine, {14, 14}).cycles;
}

// As machine_test counts them: 11 to the tag check, turns of both parts' stages and three cycles, and 9 back to the DSP's end.
TEST(PipelineCost, IsBothPartsStagesAndThreeCyclesAPass) {
  for (const auto& [prefetch, compute] : {std::pair(16, 16), std::pair(3, 5), std::pair(7, 1), std::pair(1, 9)}) {
    for (const int samples : {1, 2, 6}) {
      EXPECT_EQ(lone_ray_cycles({"ideal.memory=1", "pipeline.prefetch_stages=" + std::to_string(prefetch),
                                 "pipeline.compute_stages=" + std::to_string(compute)},
                                samples),
                static_cast<unsigned>(7 + 4 + (prefetch + compute + 3) * (samples - 1) + prefetch + compute + 2 + 7));
    }
  }
}

// A lone ray's cold packets with nothing else on the wires: what each step takes longer, the ray takes longer, to the cycle. One
// prefetch stage hides nothing.
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
