// Measures the waits around a picture: voxels into the board, and pictures, voxels and sums out of it, through
// driver, socket and board process (threads=1; the driver's own threads beside it).
#include <benchmark/benchmark.h>

#include <vector>

#include "gicube/board.h"

namespace gicube::samples {
namespace {

constexpr const char* kBoard = "emu:?threads=1";

// Bytes of the application's samples; nothing in them is zero, so that every block is sent.
std::vector<std::byte> samples(int edge) {
  std::vector<std::byte> values(static_cast<std::size_t>(edge) * static_cast<std::size_t>(edge) *
                                static_cast<std::size_t>(edge));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::byte>(1 + i * 2654435761u % 251);
  return values;
}

// range(0): edge of the volume; range(1): gradients are found and sent.
void load_volume(benchmark::State& state) {
  const int edge = static_cast<int>(state.range(0));
  const std::vector<std::byte> values = samples(edge);
  Board board = Board::open(kBoard);
  for (auto _ : state) {
    board.load_volume({.samples = values, .dims = {edge, edge, edge}, .find_gradients = state.range(1) != 0});
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * static_cast<std::int64_t>(values.size()));
}
BENCHMARK(load_volume)
    ->ArgNames({"edge", "gradients"})
    ->Args({128, 1})
    ->Args({256, 1})
    ->Args({256, 0})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// Voxels back, of half the volume's edge.
void read_volume(benchmark::State& state) {
  const int edge = static_cast<int>(state.range(0));
  const std::vector<std::byte> values = samples(edge);
  Board board = Board::open(kBoard);
  board.load_volume({.samples = values, .dims = {edge, edge, edge}});
  std::size_t read = 0;
  for (auto _ : state) read += board.read_volume({{0, 0, 0}, {edge / 2, edge / 2, edge / 2}}).size();
  state.SetItemsProcessed(static_cast<std::int64_t>(read));
}
BENCHMARK(read_volume)->ArgName("edge")->Arg(128)->UseRealTime()->Unit(benchmark::kMillisecond);

// The last picture again, range(0)^2 pixels.
void read_framebuffer(benchmark::State& state) {
  const std::vector<std::byte> values = samples(16);
  Board board = Board::open(kBoard);
  board.load_volume({.samples = values, .dims = {16, 16, 16}});
  View view;
  view.eye = {8, 8, -30};
  view.look_at = {8, 8, 8};
  view.width = view.height = static_cast<int>(state.range(0));
  board.render(view);
  for (auto _ : state) benchmark::DoNotOptimize(board.read_framebuffer());
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * state.range(0) * state.range(0));
}
BENCHMARK(read_framebuffer)->ArgName("image")->Arg(512)->Arg(1024)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gicube::samples
