// Host rays through driver, socket and board process and back; short rays, so that the transport weighs most. The
// driver's threads and the board process (threads=1) share the machine: for one core end to end run it under `taskset
// -c 0`.
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

// Between random points of a volume of 128^3, as visibility asks: 84 voxels a ray on average, in steps of one.
// `density`: of a fog in which nothing ends and nothing can be leapt over.
struct Visibility {
  static constexpr int kEdge = 128;

  Visibility() : board(Board::open("emu:?threads=2")) {
    std::vector<std::byte> fog(std::size_t{kEdge} * kEdge * kEdge);
    for (std::size_t i = 0; i < fog.size(); ++i) fog[i] = static_cast<std::byte>(60 + i * 2654435761u % 97);
    board.load_volume({.samples = fog, .dims = {kEdge, kEdge, kEdge}});
    TransferFunction function;
    function.opacities = {{0, 0}, {255, 0.02}};
    function.colours = {{0, {1, 1, 1}}};
    board.set_transfer_function(function);
  }

  static Vec3 point(std::uint64_t i) {
    const auto axis = [&](std::uint64_t which) {  // SplitMix64 (Steele, Lea, Flood 2014)
      std::uint64_t x = (3 * i + which + 1) * 0x9E3779B97F4A7C15u;
      x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
      x = (x ^ x >> 27) * 0x94D049BB133111EBu;
      return static_cast<double>((x ^ x >> 31) >> 11) * 0x1p-53 * (kEdge - 1);
    };
    return {axis(0), axis(1), axis(2)};
  }

  Board board;
};

const RayRequest kOneApart{.type = RayType::kOpacity, .step = 1};

// Host-made rays, four batches of range(0) under way, transport included.
void visibility_by_host(benchmark::State& state) {
  Visibility scene;
  std::vector<HostRay> rays;
  for (std::size_t i = 0; i < static_cast<std::size_t>(state.range(0)); ++i) {
    rays.push_back(ray_between(static_cast<std::uint32_t>(i), scene.point(2 * i), scene.point(2 * i + 1)));
  }
  std::vector<TracedRay> room(rays.size());
  std::vector<Ticket> tickets(4);
  for (Ticket& ticket : tickets) ticket = scene.board.submit(rays, kOneApart);
  std::size_t next = 0;
  for (auto _ : state) {
    scene.board.receive(tickets[next], room);
    tickets[next] = scene.board.submit(rays, kOneApart);
    next = (next + 1) % tickets.size();
    benchmark::DoNotOptimize(room.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * state.range(0));
}
BENCHMARK(visibility_by_host)->Arg(262144)->UseRealTime()->Unit(benchmark::kMillisecond);

// Rays that the board makes between boxes of one voxel, range(0) a pair.
void visibility_by_board(benchmark::State& state) {
  Visibility scene;
  std::vector<Element> elements;
  std::vector<ElementPair> pairs;
  for (std::uint32_t i = 0; i < 4096; ++i) {
    Vec3 at = scene.point(i);
    for (double* x : {&at.x, &at.y, &at.z}) *x *= 0.99;
    elements.push_back({ElementKind::kBox, at, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  }
  const auto count = static_cast<std::uint32_t>(262'144 / state.range(0));
  for (std::uint32_t i = 0; i < count; ++i) pairs.push_back({i % 4096, (i * 1237 + 511) % 4096, i});
  const PairRequest request{.rays = static_cast<std::uint32_t>(state.range(0)), .step = 1};
  for (auto _ : state) benchmark::DoNotOptimize(scene.board.pair_factors(elements, pairs, request));
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * count * state.range(0));
}
BENCHMARK(visibility_by_board)->Arg(1)->Arg(16)->Arg(64)->UseRealTime()->Unit(benchmark::kMillisecond);

// From submit() to the ray: what one ray takes that the application waits for.
void one_ray(benchmark::State& state) {
  Board board = fog_board();
  const auto rays = short_rays(1);
  for (auto _ : state) benchmark::DoNotOptimize(board.receive(board.submit(rays, {.type = RayType::kOpacity})));
}
BENCHMARK(one_ray)->UseRealTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gicube::samples
