// Pictures of whole scenes at the functional level, through driver, socket and board process: 512 x 512 pixels, shaded,
// in perspective, half-voxel steps. What a frame takes, and samples a second of wall clock and of the board's processor
// time (docs/studies/speed.md).
#include <benchmark/benchmark.h>

#include <filesystem>

#include "gicube/board.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"
#include "scene/program/host_usage.h"

namespace gicube::samples {
namespace {

enum class Look { kOpaque, kFog, kClear };

Scene buckyball() {
  Scene scene;
  scene.volume.builtin = "buckyball";
  return scene;
}

Scene engine() {
  Scene scene;
  scene.volume.file = std::filesystem::path(GICUBE_SOURCE_DIR) / "../shared/data/engine_ct/engine.nii.gz";
  scene.transfer_function = find_preset("ct-engine");
  return scene;
}

// Every sample has an opacity, and no ray ends before it leaves the volume.
TransferFunction fog(const ValueRange& range) {
  return {.colours = {{range.low, {0.3, 0.5, 0.9}}, {range.high, {1, 0.8, 0.4}}},
          .opacities = {{range.low, 0.002}, {range.high, 0.02}}};
}

void picture(benchmark::State& state, const Scene& scene, Look look, const char* board_options) {
  if (!scene.volume.file.empty() && !std::filesystem::exists(scene.volume.file)) {
    return state.SkipWithError("the scan is not there");
  }
  SceneSetup setup = set_up(scene);
  Board board = Board::open("emu:?threads=" + std::to_string(state.range(0)) + board_options);
  board.set_shading(setup.shading);
  board.load_volume(setup.volume_view());
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    board.set_transfer_function(look == Look::kFog ? fog(range) : in_values_of(range, setup.materials[tag]),
                                static_cast<int>(tag));
  }
  View view = setup.view;
  if (look == Look::kFog) view.opacity_threshold = 1;
  if (look == Look::kClear) view.leap = false;  // as opaque, but each sample in empty blocks is taken
  board.render(view);
  const auto count = [&board](const char* name) { return static_cast<double>(board.counters().value(name)); };
  const double seconds = host_usage().boards.value_or(HostUsage{}).cpu_seconds;
  const double samples = count("pipeline.samples"), visible = count("pipeline.visible_samples");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(view));
  const double taken = count("pipeline.samples") - samples;
  state.SetItemsProcessed(static_cast<std::int64_t>(taken));
  const double used = host_usage().boards.value_or(HostUsage{}).cpu_seconds - seconds;  // in steps of 10 ms
  state.counters["samples_a_cpu_second"] = taken / used;
  state.counters["board_cpu_ms"] = 1000 * used / static_cast<double>(state.iterations());
  state.counters["samples_a_frame"] = taken / static_cast<double>(state.iterations());
  state.counters["visible"] = (count("pipeline.visible_samples") - visible) / taken;
}

void cases(benchmark::internal::Benchmark* bench) {
  bench->ArgName("threads")->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
}

BENCHMARK_CAPTURE(picture, buckyball, buckyball(), Look::kOpaque, "")->Apply(cases);
BENCHMARK_CAPTURE(picture, buckyball_no_leap, buckyball(), Look::kClear, "")->Apply(cases);
BENCHMARK_CAPTURE(picture, buckyball_fog, buckyball(), Look::kFog, "")->Apply(cases);
BENCHMARK_CAPTURE(picture, buckyball_fog_wide, buckyball(), Look::kFog, "&set=asic.datapath=wide")->Apply(cases);
BENCHMARK_CAPTURE(picture, engine, engine(), Look::kOpaque, "")->Apply(cases);
BENCHMARK_CAPTURE(picture, engine_no_leap, engine(), Look::kClear, "")->Apply(cases);
BENCHMARK_CAPTURE(picture, engine_fog, engine(), Look::kFog, "")->Apply(cases);
BENCHMARK_CAPTURE(picture, engine_fog_wide, engine(), Look::kFog, "&set=asic.datapath=wide")->Apply(cases);

}  // namespace
}  // namespace gicube::samples
