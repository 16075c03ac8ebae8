// Passes of lighting rays and scattered rays: about the time, the traffic and the hits of the cycle level.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "approximate/pass_machine.h"
#include "approximate/traced_passes.h"
#include "lighting_rig.h"

namespace gicube::emu {
namespace {

constexpr int kLitEdge = 48;

struct LitCase {
  std::string name;
  std::vector<std::string> machine;
  wire::Albedo albedo = wire::Albedo::kLow;
  wire::Bsdf bsdf = wire::Bsdf::kIsotropic;
  double extinction = 0.05;
};

struct LitFigures {
  double cycles = 0, reads = 0, writes = 0, hits = 0;
};

LitFigures lit_figures(Cycle cycles, const std::vector<wire::Counter>& list) {
  const auto of = [&list](const std::string& name) {
    for (const wire::Counter& counter : list) {
      if (counter.name == name) return static_cast<double>(counter.value);
    }
    ADD_FAILURE() << name;
    return 0.0;
  };
  return {static_cast<double>(cycles), of("rdram.reads"), of("rdram.writes"),
          1 - of("processor.cache.missed_voxels") / (8 * of("processor.cache.checks"))};
}

class LitPasses : public testing::TestWithParam<LitCase> {};

TEST_P(LitPasses, TakeAboutTheTimeAndTheTrafficOfTheCycleLevel) {
  const LitCase& test = GetParam();
  std::vector<std::string> assignments = test.machine;
  assignments.insert(assignments.end(), {"asic.block_voxels=16", "asic.max_volume_voxels=64"});
  const v1::BoardConfig config = config_with(assignments);
  const wire::IlluminateCommand light =
      light_of(wire::LightKind::kPoint, 1e6, {kLitEdge / 2.0, -20, kLitEdge / 2.0}, 2, test.albedo);
  const auto lit = [&](const auto& run) {
    LitScene at({kLitEdge, kLitEdge, kLitEdge}, 16, false);
    at.medium(test.extinction, 0.6, test.bsdf);
    at.scene.frame.rules = light.rules;
    at.scene.set_depths();
    const LightingRays maker = at.rays(light);
    LightRays rays(maker, at.scene.frame);
    return run(rays, at.scene);
  };
  Progress work;
  const LitFigures exact = lit([&](RaySource& rays, Scene& scene) {
    Machine machine(config, scene.volume.blocks());
    const RunResult ran = machine.run(rays, scene.frame, work);
    std::vector<wire::Counter> list;
    count(machine, list);
    return lit_figures(ran.cycles, list);
  });
  const LitFigures got = lit([&](RaySource& rays, Scene& scene) {
    PassMachine machine(config, scene.volume.blocks());
    TracedPasses passes(rays, {0, rays.count()}, scene.frame, nullptr, 1, config.cache().splat_rule());
    const RunResult ran = machine.run(passes, scene.frame, work, false);
    std::vector<wire::Counter> list;
    machine.count(list);
    return lit_figures(ran.cycles, list);
  });
  EXPECT_NEAR(got.cycles / exact.cycles, 1, 0.045);
  EXPECT_NEAR(got.reads / exact.reads, 1, 0.06);
  EXPECT_NEAR(got.writes / exact.writes, 1, 0.05);
  EXPECT_NEAR(got.hits, exact.hits, 0.011);
  std::printf("%-24s cycles %+.2f%%, reads %+.2f%%, writes %+.2f%%, hit ratio %.4f against %.4f\n", test.name.c_str(),
              100 * (got.cycles / exact.cycles - 1), 100 * (got.reads / exact.reads - 1),
              100 * (got.writes / exact.writes - 1), got.hits, exact.hits);
}

INSTANTIATE_TEST_SUITE_P(
    Of, LitPasses,
    testing::Values(LitCase{.name = "low_albedo", .machine = {}},
                    LitCase{.name = "photons", .machine = {}, .albedo = wire::Albedo::kHigh},
                    LitCase{.name = "straight", .machine = {}, .bsdf = wire::Bsdf::kNone, .extinction = 0.02},
                    LitCase{.name = "thick", .machine = {}, .extinction = 0.5},
                    LitCase{.name = "eight_processors",
                            .machine = {"asic.processors=8", "asic.partition=skewed_block", "dsp.clock_khz=1000000"}},
                    LitCase{.name = "one_processor_fast_dsp",
                            .machine = {"asic.processors=1", "dsp.clock_khz=1000000"}},
                    LitCase{.name = "all_samples_write", .machine = {"cache.splat_rule=all_samples"}},
                    LitCase{.name = "write_through",
                            .machine = {"cache.write_policy=write_through", "cache.splat_rule=visible_samples"}}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace gicube::emu
