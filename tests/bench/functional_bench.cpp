// Samples a second of the functional level on one core. Compare figures of one run with one another.
#include <benchmark/benchmark.h>

#include "ball_board.h"

namespace gicube::emu {
namespace {

// range(0): opacity per voxel in 1/65535 above half density; range(1): shading.
void functional_samples(benchmark::State& state) {
  static BallBoard board = [] {
    v1::BoardConfig config;
    config.set_threads(1);
    return BallBoard(config);
  }();
  board.set_opacity(static_cast<std::uint16_t>(state.range(0)));
  board.write_register(wire::reg::kPipeline, state.range(1) != 0 ? wire::kPipelineShade : 0u);
  const std::uint64_t before = board.counter("pipeline.samples");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(corner_view({kBallSize, kBallSize, kBallSize}, 256)));
  state.SetItemsProcessed(static_cast<std::int64_t>(board.counter("pipeline.samples") - before));
}
BENCHMARK(functional_samples)
    ->ArgNames({"opacity", "shade"})
    ->Args({0, 0})
    ->Args({600, 0})
    ->Args({600, 1})
    ->Args({30000, 1})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gicube::emu
