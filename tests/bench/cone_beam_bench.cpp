// Filtered backprojection by the board, functional level over the socket pair, both processes on all cores; next to its
// time the errors against the phantom, and those of the double-precision voxel-driven reconstruction of the same
// projections.
#include <benchmark/benchmark.h>

#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <span>
#include <string>
#include <tuple>

#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "cone_beam/view_rays.h"
#include "reference/fdk.h"
#include "reference/fdk_phantoms.h"

namespace gicube::samples {
namespace {

// A head of 80 units half height, whose shadow the detector of `size`^2 catches whole; voxels as large as its pixels
// are at the axis, up to rounding.
ConeGeometry scan(int size, int voxels, int views) {
  ConeGeometry geometry;
  geometry.source_to_axis = 500;
  geometry.source_to_detector = 1000;
  geometry.detector = {size, size, 400.0 / size, 400.0 / size};
  geometry.volume = {{voxels, voxels, voxels}, (180.0 / voxels) * Vec3{1, 1, 1}};
  geometry.angles = even_angles(views, 0, 2 * std::numbers::pi);
  return geometry;
}

constexpr double kRadius = 85,
                 kHalfHeight = 45;  // of what is compared: the phantom and air around it, small cone angles

struct Scan {
  ConeGeometry geometry;
  Projections projections;
  std::vector<float> truth;
  double reference_rmse = 0;
};

const Scan& scan_of(int voxels, int views, int phantom) {
  static std::map<std::tuple<int, int, int>, Scan> kept;
  Scan& scan = kept[{voxels, views, phantom}];
  if (!scan.truth.empty()) return scan;
  const Phantom what = phantom == 0   ? uniform_sphere(70, 1)
                       : phantom == 1 ? shepp_logan(85)
                                      : high_contrast_shepp_logan(85);
  scan.geometry = samples::scan(256, voxels, views);
  scan.projections = project(what, scan.geometry);
  scan.truth = samples::voxels(what, scan.geometry.volume);
  const auto values = reference::reconstruct(scan.geometry, scan.projections);
  scan.reference_rmse = reference::difference(scan.geometry.volume, values, scan.truth, kRadius, kHalfHeight).rmse;
  return scan;
}

// Voxels an edge, views, rays a pixel's edge, phantom (0 sphere, 1 Kak-Slaney, 2 Yu-Ye-Wang).
void fdk(benchmark::State& state) {
  const Scan& scan =
      scan_of(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), static_cast<int>(state.range(3)));
  Reconstruction made;
  for (auto _ : state) {
    Board board = Board::open("emu:");
    made = reconstruct_fdk(board, scan.geometry, scan.projections,
                           {.rays = static_cast<int>(state.range(2)), .sharpen = 0.1, .normalise = false});
  }
  const auto off = reference::difference(scan.geometry.volume, made.values, scan.truth, kRadius, kHalfHeight);
  state.counters["rmse"] = off.rmse;
  state.counters["bias"] = off.bias;
  state.counters["reference_rmse"] = scan.reference_rmse;
  state.counters["ratio"] = off.rmse / scan.reference_rmse;
  state.counters["deposits"] = static_cast<double>(made.deposits);
  state.counters["board_s"] = static_cast<double>(made.board_time) * 1e-12;
  state.counters["overflowed"] = static_cast<double>(made.overflowed);
}
BENCHMARK(fdk)
    ->ArgNames({"voxels", "views", "rays", "phantom"})
    ->ArgsProduct({{128}, {180}, {1, 2}, {0, 1, 2}})
    ->Args({256, 360, 1, 1})
    ->Args({256, 360, 2, 1})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kSecond);

// A view's time at the cycle level, from two and eight of them evenly around the turn.
double ms_of_a_view(const ConeGeometry& geometry, const Projections& projections, const FdkSettings& settings) {
  Board board = Board::open("emu:?fidelity=cycle");
  const auto time = [&](std::size_t views) {
    const std::size_t every = geometry.angles.size() / views;
    ConeGeometry few = geometry;
    Projections some{projections.columns, projections.rows, {}};
    few.angles.clear();
    for (std::size_t i = 0; i < views; ++i) {
      few.angles.push_back(geometry.angles[i * every]);
      const float* const view = projections.view(i * every);
      some.values.insert(some.values.end(), view, view + projections.view_size());
    }
    return 1e-9 * static_cast<double>(reconstruct_fdk(board, few, some, settings).board_time);
  };
  return (time(8) - time(2)) / 6;
}

// The four scans of tests/support/reference/fdk_phantoms.h, 64 voxels along x, all voxels against the object's means in
// them; by one ray a pixel and sharpened by 0.1, or by the defaults.
void fdk_of_four_scans(benchmark::State& state) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const reference::FdkScan scan = reference::fdk_scans(64)[static_cast<std::size_t>(state.range(0))];
  const Projections projections = project(scan);
  const std::vector<double> truth = mean_in_voxels(scan);
  const auto rmse = [&](const auto& values) {
    return reference::difference(scan.geometry.volume, values, truth, kAll, kAll).rmse;
  };
  const FdkSettings settings = state.range(1) == 0 ? FdkSettings{.rays = 1, .sharpen = 0.1} : FdkSettings{};
  Reconstruction made;
  for (auto _ : state) {
    Board board = Board::open("emu:");
    made = reconstruct_fdk(board, scan.geometry, projections, settings);
  }
  const double reference_rmse = rmse(reference::reconstruct(scan.geometry, projections));
  state.SetLabel(scan.name);
  state.counters["reference_rmse"] = reference_rmse;
  state.counters["rmse"] = rmse(made.values);
  state.counters["ratio"] = rmse(made.values) / reference_rmse;
  state.counters["rays"] = static_cast<double>(made.rays);
  state.counters["deposits"] = static_cast<double>(made.deposits);
  state.counters["view_ms"] = ms_of_a_view(scan.geometry, projections, settings);
}
BENCHMARK(fdk_of_four_scans)
    ->ArgNames({"scan", "defaults"})
    ->ArgsProduct({{0, 1, 2, 3}, {0, 1}})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kSecond);

// One view into 128^3 at the cycle level: what its time goes into, as parts of all processors' cycles.
void fdk_view_at_cycle_level(benchmark::State& state) {
  const ConeGeometry geometry = scan(256, 128, 180);
  const Projections projections = project(shepp_logan(85), geometry);
  const RampFilter filter = ramp_filter(geometry, Window::kRamLak);
  const std::vector<double> view = filtered_view(projections, geometry, 0, filter, {});
  double most = 0;
  for (const double value : view) most = std::max(most, std::abs(value));
  Counters counters;
  for (auto _ : state) {
    Board board = Board::open("emu:?fidelity=cycle");
    Projector projector = projector_of(board, geometry, 1);
    projector.load_nothing();
    const Counters before = board.counters();
    const std::array<std::size_t, 1> first{0};
    benchmark::DoNotOptimize(projector.backproject(first, most, [&](std::size_t) { return view; }));
    counters = board.counters() - before;
  }
  const auto value = [&counters](const std::string& name) { return static_cast<double>(counters.value(name)); };
  const double cycles = value("asic.cycles");
  state.counters["asic_ms"] = cycles / 1e5;
  state.counters["deposits"] = value("pipeline.deposits");
  for (const char* cause : {"busy", "splat", "latency", "sorter", "dsp_compute", "sdram", "queue_empty", "ray_bus"}) {
    state.counters[cause] = value(std::string("processor.cycles.") + cause) / (4 * cycles);
  }
  // Of the four RDRAM channels' own cycles, those with data on the wires; the paper has 92% for lighting.
  double data = 0, all = 0;
  for (int channel = 0; channel < 4; ++channel) {
    const std::string prefix = "rdram" + std::to_string(channel) + ".";
    data += value(prefix + "data_busy");
    all += value(prefix + "cycles");
  }
  state.counters["memory"] = data / all;
  state.counters["carriers"] = value("processor.splat.carriers");
  state.counters["rays_bus_ms"] = value("bus.rays.time_ps") * 1e-9;
  state.counters["read_ms"] = value("bus.volume.time_ps") * 1e-9;
}
BENCHMARK(fdk_view_at_cycle_level)->Iterations(1)->UseRealTime()->Unit(benchmark::kSecond);

}  // namespace
}  // namespace gicube::samples
