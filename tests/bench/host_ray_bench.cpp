// Host rays through driver, socket and board process and back; short rays, so that the transport weighs most. The driver's
// threads and the board process (threads=1) share the machine: for one core end to end run it under `taskset -c 0`.
#include <benchmark/benchmark.h>

#include <vector>

#include "gicube/board.h"

namespace gicube::samples {
namespace {

constexpr int kSize = 64;

Board fog_board() {
  Board board = Board::open("emu:?threads=1");
  const std::vector<std::byte> fog(std::size_t{kSize} * kSize * kSize, std::byte{100});
  board.load_volume({.samples = fog, .dims = {kSize, kSize, kSize}});
  TransferFunction function;
  function.opacities = {{0, 0.02}, {255, 0.02}};
  function.colours = {{0, {1, 1, 1}}};
  board.set_transfer_function(function);
  return board;
}

// Four voxels long: eight samples.
std::vector<HostRay> short_rays(std::size_t count) {
  std::vector<HostRay> rays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = 1 + static_cast<double>(i % 59), y = 1 + static_cast<double>(i / 59 % 59);
    rays[i] = {.id = static_cast<std::uint32_t>(i), .position = {x, y, 8.5}, .direction = {0.1, 0.2, 1}, .length = 4};
  }
  return rays;
}

// Batches of range(0) rays, four under way.
void host_rays(benchmark::State& state) {
  Board board = fog_board();
  const auto rays = short_rays(static_cast<std::size_t>(state.range(0)));
  std::vector<TracedRay> room(rays.size());
  constexpr std::size_t kUnderWay = 4;
  std::vector<Ticket> tickets;
  for (std::size_t i = 0; i < kUnderWay; ++i) tickets.push_back(board.submit(rays, {.type = RayType::kOpacity}));
  std::size_t next = 0;
  for (auto _ : state) {
    board.receive(tickets[next], room);
    tickets[next] = board.submit(rays, {.type = RayType::kOpacity});
    next = (next + 1) % kUnderWay;
    benchmark::DoNotOptimize(room.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * state.range(0));
}
BENCHMARK(host_rays)->Arg(4096)->Arg(65536)->Arg(262144)->UseRealTime()->Unit(benchmark::kMillisecond);

// From submit() to the ray: what one ray takes that the application waits for.
void one_ray(benchmark::State& state) {
  Board board = fog_board();
  const auto rays = short_rays(1);
  for (auto _ : state) benchmark::DoNotOptimize(board.receive(board.submit(rays, {.type = RayType::kOpacity})));
}
BENCHMARK(one_ray)->UseRealTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gicube::samples
