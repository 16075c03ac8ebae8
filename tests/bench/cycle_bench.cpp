// Samples a second that the cycle level simulates at the design point, on one core: the issue asks for 10 million.
#include <benchmark/benchmark.h>

#include "ball_board.h"

namespace gicube::emu {
namespace {

// range(0): image edge in pixels; range(1): opacity per voxel in 1/65535 above half density; range(2): rays leap over
// empty blocks. Shaded, half-voxel steps.
void cycle_samples(benchmark::State& state) {
  static BallBoard board = [] {
    v1::BoardConfig config;
    config.set_threads(1);
    config.set_fidelity(v1::cycle);
    return BallBoard(config);
  }();
  board.set_opacity(static_cast<std::uint16_t>(state.range(1)));
  board.write_register(wire::reg::kPipeline, wire::kPipelineShade | (state.range(2) != 0 ? wire::kPipelineLeap : 0u));
  const wire::RenderCommand view = corner_view({kBallSize, kBallSize, kBallSize}, static_cast<int>(state.range(0)));
  board.render(view);  // decodes the volume, which is no part of the level's speed
  const std::uint64_t samples = board.counter("pipeline.samples"), cycles = board.counter("asic.cycles");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(view));
  state.SetItemsProcessed(static_cast<std::int64_t>(board.counter("pipeline.samples") - samples));
  state.counters["core_cycles_per_s"] =
      benchmark::Counter(static_cast<double>(board.counter("asic.cycles") - cycles), benchmark::Counter::kIsRate);
}
BENCHMARK(cycle_samples)
    ->ArgNames({"image", "opacity", "leap"})
    ->Args({256, 600, 0})
    ->Args({256, 30000, 1})
    ->Args({512, 30000, 1})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gicube::emu
