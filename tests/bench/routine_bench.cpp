// Scattering routines: a call of one, and the lighting of a fog that traps every ray that it scatters. A plug-in's call
// crosses to another process and back; a built-in routine is a function.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "bare_board.h"
#include "config/config.h"
#include "firmware/routines/routine_table.h"

namespace gicube::emu {
namespace {

const RoutineTable& routines() {
  static const auto table = [] {
    auto made = std::make_unique<RoutineTable>();
    made->add(PlugIn::load(GICUBE_BIN_DIR "/brushed_metal.so"));
    return made;
  }();
  return *table;
}

// range(0): the routine's number.
void routine_call(benchmark::State& state) {
  const std::array<float, 6> grooves{1, 0, 0, 0.2f, 0.02f, 0.75f}, glass{1.5f};
  ScatterEvent event;
  event.direction = {0, 0.6, -0.8};
  event.normal = {0, 0, 1};
  event.random = {0.1, 0.2, 0.3, 0.4};
  const bool is_plug_in = state.range(0) == kFirstUserRoutine;
  event.parameters = is_plug_in ? std::span(grooves) : std::span(glass).first(1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(routines().scatter(static_cast<std::uint8_t>(state.range(0)), event));
  }
}
BENCHMARK(routine_call)->ArgName("routine")->Arg(0)->Arg(kFirstUserRoutine)->ThreadRange(1, 2)->UseRealTime();

// range(0): the routine's number; range(1): threads of the board.
void trapped_light(benchmark::State& state) {
  v1::BoardConfig config;
  config.mutable_asic()->set_block_voxels(16);
  config.set_threads(static_cast<std::uint32_t>(state.range(1)));
  BareBoard board(resolve(config), nullptr, &routines());
  board.load_volume({32, 32, 32}, [](int, int, int) { return wire::Voxel{1000, 0, 0, 0}; });
  board.write_segmentation([](unsigned, unsigned) {
    wire::SegmentationEntry entry;
    entry.opacity = wire::kClassifiedOpacityOne / 5;
    return entry;
  });
  wire::Material material;
  material.bsdf = wire::Bsdf::kTrap;
  material.scattering = wire::kScatteringOne;
  material.routine = static_cast<std::uint8_t>(state.range(0));
  std::vector<std::uint8_t> bytes(wire::kMaterialBytes);
  wire::encode(material, bytes);
  board.write_memory(wire::kMaterials.base, bytes);
  wire::IlluminateCommand command;
  command.energy = 30'000;
  command.position = {15, 16, 17};
  command.rays_per_voxel = command.count = 2;
  std::vector<std::uint8_t> payload(wire::kIlluminateCommandBytes);
  wire::encode(command, payload);
  const auto light = [&] {
    const Completion done = board.wait(board.command(payload)).completions.at(0);
    if (done.error != wire::ErrorCode::kNone) state.SkipWithError("the command failed");
  };
  light();  // the counter is there from the first light on
  const std::uint64_t before = board.counter("pipeline.traps");
  for (auto _ : state) light();
  state.SetItemsProcessed(static_cast<std::int64_t>(board.counter("pipeline.traps") - before));
}
BENCHMARK(trapped_light)
    ->ArgNames({"routine", "threads"})
    ->ArgsProduct({{1, kFirstUserRoutine}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace gicube::emu
