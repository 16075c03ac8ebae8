// The demo's own frame through driver, socket and board process: what a user waits for, on one core (threads=1).
#include <benchmark/benchmark.h>

#include "gicube/board.h"
#include "gicube/scene/scene.h"
#include "scene/names.h"

namespace gicube::samples {
namespace {

// Demo scene at the design point's 256^3, image edge range(0); the first frame, which decodes the volume, is not
// counted.
void demo_frame(benchmark::State& state, const char* uri) {
  Scene scene;
  scene.volume.builtin = "buckyball";
  scene.view.width = scene.view.height = static_cast<int>(state.range(0));
  SceneSetup setup = set_up(scene);
  Board board = Board::open(uri);
  board.set_shading(setup.shading);
  board.load_volume(setup.volume_view());
  const ValueRange range = board.value_range();
  for (std::size_t tag = 0; tag < setup.materials.size(); ++tag) {
    board.set_transfer_function(in_values_of(range, setup.materials[tag]), static_cast<int>(tag));
  }
  board.render(setup.view);
  const std::uint64_t before = board.counters().value("pipeline.samples");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(setup.view));
  state.SetItemsProcessed(static_cast<std::int64_t>(board.counters().value("pipeline.samples") - before));
}
BENCHMARK_CAPTURE(demo_frame, functional, "emu:?threads=1")
    ->Arg(256)
    ->Arg(512)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(demo_frame, cycle, "emu:?threads=1&fidelity=cycle")
    ->Arg(256)
    ->Arg(512)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gicube::samples
