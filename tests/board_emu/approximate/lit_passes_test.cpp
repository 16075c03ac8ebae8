// Passes of lighting rays and scattered rays: about the time, the traffic and the hits of the cycle level.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "approximate/pass_machine.h"
#include "approximate/traced_passes.h"
#include "bare_board.h"
#include "lighting_rig.h"
#include "memory/sum_memory.h"

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

// Parts by which the figures may differ.
struct Within {
  double cycles, reads, writes;
};

// `run_in(run)` makes a new scene of 48^3 voxels, and calls run(rays, frame).
template <typename RunIn>
void expect_alike(const std::string& name, const v1::BoardConfig& config, const Within& within, const RunIn& run_in) {
  Progress work;
  std::vector<wire::Counter> list;
  const LitFigures exact = run_in([&](RaySource& rays, const Frame& frame) {
    Machine machine(config, frame.volume->blocks());
    const RunResult ran = machine.run(rays, frame, work);
    count(machine, list);
    return lit_figures(ran.cycles, list);
  });
  list.clear();
  const LitFigures got = run_in([&](RaySource& rays, const Frame& frame) {
    PassMachine machine(config, frame.volume->blocks());
    TracedPasses passes(rays, {0, rays.count()}, frame, nullptr, 1, config.cache().splat_rule());
    const RunResult ran = machine.run(passes, frame, work, false);
    machine.count(list);
    return lit_figures(ran.cycles, list);
  });
  EXPECT_NEAR(got.cycles / exact.cycles, 1, within.cycles);
  EXPECT_NEAR(got.reads / exact.reads, 1, within.reads);
  EXPECT_NEAR(got.writes / exact.writes, 1, within.writes);
  EXPECT_NEAR(got.hits, exact.hits, 0.011);
  std::printf("%-24s cycles %+.2f%%, reads %+.2f%%, writes %+.2f%%, hit ratio %.4f against %.4f\n", name.c_str(),
              100 * (got.cycles / exact.cycles - 1), 100 * (got.reads / exact.reads - 1),
              100 * (got.writes / exact.writes - 1), got.hits, exact.hits);
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
    return run(rays, at.scene.frame);
  };
  expect_alike(test.name, config, {0.02, 0.045, 0.02}, lit);
}

INSTANTIATE_TEST_SUITE_P(
    Of, LitPasses,
    testing::Values(
        LitCase{.name = "low_albedo", .machine = {}},
        LitCase{.name = "photons", .machine = {}, .albedo = wire::Albedo::kHigh},
        LitCase{.name = "straight", .machine = {}, .bsdf = wire::Bsdf::kNone, .extinction = 0.02},
        LitCase{.name = "thick", .machine = {}, .extinction = 0.5},
        LitCase{.name = "eight_processors",
                .machine = {"asic.processors=8", "asic.partition=skewed_block", "dsp.clock_khz=1000000"}},
        LitCase{.name = "one_processor_fast_dsp", .machine = {"asic.processors=1", "dsp.clock_khz=1000000"}},
        LitCase{.name = "all_samples_write", .machine = {"cache.splat_rule=all_samples"}},
        LitCase{.name = "write_through",
                .machine = {"cache.write_policy=write_through", "cache.splat_rule=visible_samples"}},
        LitCase{.name = "write_back", .machine = {"cache.write_policy=write_back"}},
        LitCase{.name = "most_contribution", .machine = {"sorter.policy=most_contribution"}},
        LitCase{.name = "photons_most_contribution",
                .machine = {"sorter.policy=most_contribution", "asic.processors=1", "dsp.clock_khz=1000000"},
                .albedo = wire::Albedo::kHigh},
        LitCase{.name = "irradiance_in_cells", .machine = {"cache.irradiance=in_cells"}},
        LitCase{.name = "in_cells_written_back",
                .machine = {"cache.irradiance=in_cells", "cache.write_policy=write_back"}},
        LitCase{.name = "two_ports", .machine = {"cache.ports=2"}},
        LitCase{.name = "shared_rdram", .machine = {"rdram.processors_per_rdram=2", "dsp.clock_khz=1000000"}}),
    [](const auto& test) { return test.param.name; });

class BackprojectingPasses : public testing::TestWithParam<LitCase> {};

// A view of a cone beam: rays through the pixels of a detector, each with an amount of its own.
std::vector<wire::Ray> cone_beam_view(int pixels) {
  const std::array<double, 3> source{-150, 60, 25};
  std::vector<wire::Ray> rays;
  for (int i = 0; i < pixels * pixels; ++i) {
    const double u = (i % pixels + 0.5) / pixels - 0.5, v = (i / pixels + 0.5) / pixels - 0.5;
    std::array<double, 3> along{1 + 0.1 * u, 0.36 * u - 0.2, 0.36 * v}, position = source;
    const double length = std::hypot(along[0], along[1], along[2]);
    for (std::size_t axis = 0; axis < 3; ++axis) along[axis] /= length;
    const double to_face = (0.25 - source[0]) / along[0];
    bool hits = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] += to_face * along[axis];
      hits = hits && position[axis] >= 0 && position[axis] < kLitEdge - 1;
    }
    if (!hits) continue;
    rays.push_back(host_ray(static_cast<std::uint32_t>(i), position, along));
    rays.back().set_colour_word(60 << 16);
    rays.back().opacity = static_cast<std::uint32_t>(i * 37 % 5000 - 2500) & wire::kOpacityOne;
  }
  return rays;
}

TEST_P(BackprojectingPasses, TakeAboutTheTimeAndTheTrafficOfTheCycleLevel) {
  std::vector<std::string> assignments = GetParam().machine;
  assignments.insert(assignments.end(), {"asic.block_voxels=16", "asic.max_volume_voxels=64"});
  std::vector<std::vector<std::uint8_t>> all;
  expect_alike(GetParam().name, config_with(assignments), {0.045, 0.05, 0.04}, [&](const auto& run) {
    Scene scene({kLitEdge, kLitEdge, kLitEdge}, 16);
    SumMemory sums(16);
    sums.resize({kLitEdge, kLitEdge, kLitEdge});
    Frame& frame = scene.frame;
    frame.type = wire::RayType::kBackproject;
    frame.sums = &sums;
    frame.step = wire::kStepOne / 2;
    if (assignments.front() == "asic.datapath=wide") scene.widen();
    std::vector<wire::Ray> rays = cone_beam_view(56);
    HostRays source(rays, frame, false);
    const LitFigures out = run(source, frame);
    all.emplace_back(sums.bytes());
    sums.read(0, all.back());
    return out;
  });
  EXPECT_EQ(all.front(), all.back());
}

INSTANTIATE_TEST_SUITE_P(
    Of, BackprojectingPasses,
    testing::Values(LitCase{.name = "sums", .machine = {}},
                    LitCase{.name = "wide_sums", .machine = {"asic.datapath=wide"}},
                    LitCase{.name = "skewed_blocks_fast_dsp",
                            .machine = {"asic.processors=8", "asic.partition=skewed_block", "dsp.clock_khz=1000000"}},
                    LitCase{.name = "one_processor_fast_dsp",
                            .machine = {"asic.processors=1", "dsp.clock_khz=1000000"}},
                    LitCase{.name = "all_samples_write", .machine = {"cache.splat_rule=all_samples"}},
                    LitCase{.name = "long_write_queue", .machine = {"cache.write_packets=256"}},
                    LitCase{.name = "write_through", .machine = {"cache.write_policy=write_through"}},
                    LitCase{.name = "write_back", .machine = {"cache.write_policy=write_back"}},
                    LitCase{.name = "most_contribution", .machine = {"sorter.policy=most_contribution"}},
                    LitCase{.name = "two_ports", .machine = {"cache.ports=2"}},
                    LitCase{.name = "shared_rdram", .machine = {"rdram.processors_per_rdram=2"}}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace gicube::emu
