// What an error of a reconstruction costs the host: the head of Shepp and Logan (densities of Kak and Slaney), 256^3
// from up to 360 views of 256^2, by the board's rays at several settings (functional level over the socket pair) and by
// the double-precision voxel-driven method. script/charts cone_beam draws it.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include <numbers>
#include <vector>

#include "cone_beam/fdk.h"
#include "cone_beam/phantom/phantom.h"
#include "reference/fdk.h"

namespace gicube::samples {
namespace {

struct Scan {
  ConeGeometry geometry;
  Projections projections;
};

const Phantom kHead = shepp_logan(85);
constexpr FieldOfView kField{85, 45};  // the head and air around it, small cone angles

Scan scan_of(int views) {
  Scan scan;
  scan.geometry = {.source_to_axis = 500,
                   .source_to_detector = 1000,
                   .detector = {256, 256, 400.0 / 256, 400.0 / 256},
                   .volume = {{256, 256, 256}, (180.0 / 256) * Vec3{1, 1, 1}},
                   .angles = even_angles(views, 0, 2 * std::numbers::pi)};
  scan.projections = project(kHead, scan.geometry);
  return scan;
}

// Seconds of all cores, of this process and of those that have ended.
double cpu_seconds() {
  double sum = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    ::getrusage(who, &used);
    for (const timeval& part : {used.ru_utime, used.ru_stime}) {
      sum += static_cast<double>(part.tv_sec) + 1e-6 * static_cast<double>(part.tv_usec);
    }
  }
  return sum;
}

void report(benchmark::State& state, const ConeGeometry& geometry, const std::vector<float>& values, double seconds) {
  const std::vector<float> truth = voxels(kHead, geometry.volume);
  const Comparison error = compare(geometry.volume, values, truth, kField);
  state.counters["cpu_s"] = seconds;
  state.counters["relative_l2"] = error.relative_l2;
  state.counters["rmse"] = error.rmse;
}

// Views, rays a pixel's edge, step in halves of a voxel, window.
void cone_beam_trade(benchmark::State& state) {
  const Scan scan = scan_of(static_cast<int>(state.range(0)));
  const FdkSettings settings{.window = static_cast<Window>(state.range(3)),
                             .rays = static_cast<int>(state.range(1)),
                             .step = static_cast<double>(state.range(2)) / 2,
                             .sharpen = 0.1,
                             .normalise = false};
  for (auto _ : state) {
    const double begin = cpu_seconds();
    Reconstruction made;
    {
      Board board = Board::open("emu:");
      made = reconstruct_fdk(board, scan.geometry, scan.projections, settings);
    }
    const double seconds = cpu_seconds() - begin;
    state.PauseTiming();
    report(state, scan.geometry, made.values, seconds);
    state.ResumeTiming();
  }
}
BENCHMARK(cone_beam_trade)
    ->ArgNames({"views", "rays", "half_steps", "window"})
    ->Args({90, 1, 2, 0})
    ->Args({180, 1, 2, 0})
    ->Args({360, 1, 2, 0})
    ->Args({360, 1, 2, 1})
    ->Args({360, 1, 4, 0})
    ->Args({360, 1, 1, 0})
    ->Args({360, 2, 2, 0})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kSecond);

// Views.
void cone_beam_trade_reference(benchmark::State& state) {
  const Scan scan = scan_of(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const double begin = cpu_seconds();
    const std::vector<double> values = reference::reconstruct(scan.geometry, scan.projections);
    const double seconds = cpu_seconds() - begin;
    state.PauseTiming();
    report(state, scan.geometry, {values.begin(), values.end()}, seconds);
    state.ResumeTiming();
  }
}
BENCHMARK(cone_beam_trade_reference)
    ->ArgName("views")
    ->Arg(90)
    ->Arg(180)
    ->Arg(360)
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kSecond);

}  // namespace
}  // namespace gicube::samples
