// Samples a second of the functional level on one core, and its parts. Compare figures of one run with one another.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>

#include "bare_board.h"

namespace gicube::emu {
namespace {

constexpr int kSize = 256;

// A shaded ball, with gradients, so that most rays sample air and some gather; the shape of a usual scene.
wire::Voxel ball(int x, int y, int z) {
  const double dx = x - 127.5, dy = y - 127.5, dz = z - 127.5, r = std::sqrt(dx * dx + dy * dy + dz * dz);
  const double density = std::clamp((100 - r) / 4 + 0.5, 0.0, 1.0) * 4095;
  const auto code = static_cast<std::uint16_t>(1 + (x * 7 + y * 5 + z * 3) % 2000);
  return {static_cast<std::uint16_t>(density), density > 0 ? code : wire::kNoGradient, 0, 0};
}

BareBoard& loaded_board() {
  static BareBoard board = [] {
    v1::BoardConfig config;
    config.set_threads(1);
    return BareBoard(config);
  }();
  static const bool loaded = [] {
    board.load_volume({kSize, kSize, kSize}, ball);
    std::vector<std::uint8_t> gradients(wire::kGradientLut.bytes);
    for (std::size_t i = 1; i < wire::kGradientCodes; ++i) {
      const double a = static_cast<double>(i) * 2.4, z = 1 - static_cast<double>(i) / 1024, r = std::sqrt(1 - z * z);
      const wire::GradientEntry g{static_cast<std::int16_t>(511 * r * std::cos(a)),
                                  static_cast<std::int16_t>(511 * r * std::sin(a)), static_cast<std::int16_t>(511 * z)};
      wire::store(std::span(gradients), 4 * i, wire::to_word(g));
    }
    board.write_memory(wire::kGradientLut.base, gradients);
    board.write_memory(wire::kReflectanceMap.base, std::vector<std::uint8_t>(wire::kReflectanceBytes, 100));
    return true;
  }();
  (void)loaded;
  return board;
}

// range(0): opacity per voxel in 1/65535 above half density; range(1): shading.
void functional_samples(benchmark::State& state) {
  BareBoard& board = loaded_board();
  const auto opacity = static_cast<std::uint16_t>(state.range(0));
  board.write_segmentation([opacity](unsigned, unsigned density) {
    return wire::SegmentationEntry{{4095, 3000, 2000}, density > 2048 ? opacity : std::uint16_t{0}};
  });
  board.write_register(wire::reg::kPipeline, state.range(1) != 0 ? wire::kPipelineShade : 0u);
  board.write_register(wire::reg::kStep, wire::kStepOne / 2);
  const std::uint64_t before = board.counter("pipeline.samples");
  for (auto _ : state) benchmark::DoNotOptimize(board.render(corner_view({kSize, kSize, kSize}, 256)));
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
