// Samples a second that the cycle level simulates: at the design point on one core, and of many processors with
// threads.
#include <benchmark/benchmark.h>

#include "ball_board.h"

namespace gicube::emu {
namespace {

// Parallel rays along z, which stay together: the pipelines take a sample in most cycles.
wire::RenderCommand axis_view(int image_size) {
  wire::RenderCommand view;
  view.width = view.height = static_cast<std::uint16_t>(image_size);
  view.projection = wire::Projection::kOrthographic;
  view.origin = {0.2, 0.2, -3};
  view.forward = {0.02, 0.03, 1};
  view.du = {(kBallSize - 1.0) / image_size, 0, 0};
  view.dv = {0, (kBallSize - 1.0) / image_size, 0};
  return view;
}

// range(0): image edge in pixels; range(1): opacity per voxel in 1/65535 above half density; range(2): rays leap over
// empty blocks; range(3): view along an axis instead of from a corner, whose rays part soon. Shaded, half-voxel steps.
void cycle_samples(benchmark::State& state) {
  static BallBoard board = [] {
    v1::BoardConfig config;
    config.set_threads(1);
    config.set_fidelity(v1::cycle);
    return BallBoard(config);
  }();
  board.set_opacity(static_cast<std::uint16_t>(state.range(1)));
  board.write_register(wire::reg::kPipeline, wire::kPipelineShade | (state.range(2) != 0 ? wire::kPipelineLeap : 0u));
  const int image = static_cast<int>(state.range(0));
  const wire::RenderCommand view =
      state.range(3) != 0 ? axis_view(image) : corner_view({kBallSize, kBallSize, kBallSize}, image);
  board.render(view);  // decodes the volume, which is no part of the level's speed
  const std::uint64_t samples = board.counter("pipeline.samples"), cycles = board.counter("asic.cycles");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(view));
  state.SetItemsProcessed(static_cast<std::int64_t>(board.counter("pipeline.samples") - samples));
  state.counters["core_cycles_per_s"] =
      benchmark::Counter(static_cast<double>(board.counter("asic.cycles") - cycles), benchmark::Counter::kIsRate);
}
BENCHMARK(cycle_samples)
    ->ArgNames({"image", "opacity", "leap", "axis"})
    ->Args({256, 30000, 0, 1})
    ->Args({256, 600, 0, 0})
    ->Args({256, 30000, 1, 0})
    ->Args({512, 30000, 1, 0})
    ->Unit(benchmark::kMillisecond);

// A machine of many processors: range(0) of them; range(1): threads.
void cycle_processors(benchmark::State& state) {
  v1::BoardConfig config;
  config.set_threads(static_cast<unsigned>(state.range(1)));
  config.set_fidelity(v1::cycle);
  config.mutable_asic()->set_processors(static_cast<unsigned>(state.range(0)));
  config.mutable_asic()->set_partition(v1::skewed_block);
  BallBoard board(config);
  board.set_opacity(600);
  board.write_register(wire::reg::kPipeline, wire::kPipelineShade);
  const wire::RenderCommand view = axis_view(256);
  board.render(view);
  const std::uint64_t samples = board.counter("pipeline.samples"), cycles = board.counter("asic.cycles");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(view));
  state.SetItemsProcessed(static_cast<std::int64_t>(board.counter("pipeline.samples") - samples));
  state.counters["core_cycles"] =
      static_cast<double>(board.counter("asic.cycles") - cycles) / static_cast<double>(state.iterations());
}
BENCHMARK(cycle_processors)
    ->ArgNames({"processors", "threads"})
    ->ArgsProduct({{4, 16, 64}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gicube::emu
