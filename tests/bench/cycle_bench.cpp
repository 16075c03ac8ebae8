// Samples a second that the cycle level simulates at the design point, on one core: the issue asks for 10 million.
#include <benchmark/benchmark.h>

#include "ball_board.h"

namespace gicube::emu {
namespace {

// range(0): image edge in pixels; range(1): opacity per voxel in 1/65535 above half density. Shaded, half-voxel steps.
void cycle_samples(benchmark::State& state) {
  static BallBoard board = [] {
    v1::BoardConfig config;
    config.set_threads(1);
    config.set_fidelity(v1::cycle);
    return BallBoard(config);
  }();
  board.set_opacity(static_cast<std::uint16_t>(state.range(1)));
  board.write_register(wire::reg::kPipeline, wire::kPipelineShade);
  const wire::RenderCommand view = corner_view({kBallSize, kBallSize, kBallSize}, static_cast<int>(state.range(0)));
  const std::uint64_t samples = board.counter("pipeline.samples");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(view));
  state.SetItemsProcessed(static_cast<std::int64_t>(board.counter("pipeline.samples") - samples));
  state.counters["core_cycles_per_s"] =
      benchmark::Counter(static_cast<double>(board.counter("asic.cycles")), benchmark::Counter::kIsRate);
}
BENCHMARK(cycle_samples)
    ->ArgNames({"image", "opacity"})
    ->Args({256, 600})
    ->Args({256, 30000})
    ->Args({512, 600})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gicube::emu
