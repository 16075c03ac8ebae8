#include "cone_beam/charts/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <numeric>
#include <sstream>
#include <utility>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/names.h"
#include "scene/program/board_run.h"
#include "scene/program/run_json.h"

namespace gicube::samples {
namespace {

Projections projections_of(const Case& what) {
  Projections out = project(what.phantom, what.geometry);
  if (what.photons > 0) add_poisson_noise(out, what.photons, 1);
  return out;
}

Reconstruction made_of(Board& board, const Case& what, const Projections& projections) {
  if (const auto* fdk = std::get_if<FdkSettings>(&what.method)) {
    return reconstruct_fdk(board, what.geometry, projections, *fdk);
  }
  return reconstruct_algebraic(board, what.geometry, projections, std::get<AlgebraicSettings>(what.method));
}

// A few views around the turn; of an iterative method, so many passes through them. The same for all points whose views cost the
// same: number of views, noise and how often words are read don't matter.
Case a_part_of(const Case& what, int views, int passes) {
  constexpr double kFirst = 0.3;  // radians; not along an axis, where rays meet voxels alike
  Case part = what;
  part.geometry.angles = even_angles(views, kFirst, 2 * std::numbers::pi);
  part.photons = 0;
  if (auto* fdk = std::get_if<FdkSettings>(&part.method)) fdk->read_every = FdkSettings{}.read_every;
  if (auto* algebraic = std::get_if<AlgebraicSettings>(&part.method)) {
    *algebraic = {.method = Method::kSirt, .iterations = passes, .relaxation = 0.5, .step = algebraic->step};
  }
  return part;
}

// Parts with the same one cost the same.
std::string key_of(const Case& what) {
  const auto& g = what.geometry;
  const Detector& d = g.detector;
  const Projections projections = projections_of(what);  // of the phantom, which has no name
  std::string key = fmt::format("{:a} {} {} {} {} {} {} {} {} {}",
                                std::accumulate(projections.values.begin(), projections.values.end(), 0.0),
                                g.source_to_axis, g.source_to_detector, d.columns, d.rows, d.pitch_u, d.pitch_v,
                                g.volume.dims[0], g.volume.dims[2], g.volume.spacing.x);
  if (const auto* fdk = std::get_if<FdkSettings>(&what.method)) {
    key += fmt::format(" fdk {} {} {} {} {} {}", fdk->rays, fdk->step, static_cast<int>(fdk->accumulator),
                       fdk->normalise, fdk->bits, fdk->headroom);
  } else {
    key += fmt::format(" algebraic {}", std::get<AlgebraicSettings>(what.method).step);
  }
  return fmt::format("{} {}", key, fmt::join(what.settings, " "));
}

std::string rows_of(const Point& point, const Series& series, Runner& runner) {
  std::istringstream rows(point.rows(runner));
  std::string text, row;
  while (std::getline(rows, row)) {
    text += fmt::format("{},{},{},gicube-cone-beam charts --point {}\n", point.name, series.name, row, point.name);
  }
  return text;
}

std::string header_of(const Chart& chart) { return fmt::format("point,series,{},command\n", chart.header); }

void write_chart(const Chart& chart, const std::filesystem::path& folder, Runner& runner, ProgressLine& progress) {
  std::string text = header_of(chart);
  for (const Series& series : chart.series) {
    if (&series != &chart.series.front()) text += "\n\n";  // gnuplot's next block
    for (const Point& point : series.points) {
      progress.show(point.name);
      text += rows_of(point, series, runner);
    }
  }
  write_whole(folder / fmt::format("cone_beam_{}.csv", chart.name), text);
}

}  // namespace

Board Runner::open(const std::string& fidelity, const std::vector<std::string>& settings) const {
  BoardOptions options = board_;
  options.fidelity = fidelity;
  options.settings.insert(options.settings.end(), settings.begin(), settings.end());
  return open_board(options);
}

double Runner::rays_over_bus_ms(const Case& what) {
  const auto [known, is_new] = known_.try_emplace(key_of(a_part_of(what, 2, 1)), 0.0);
  if (!is_new) return known->second;
  const auto time = [&](const Case& part, const char* fidelity) {
    const Projections projections = projections_of(part);
    Board board = open(fidelity, part.settings);
    return to_ms(made_of(board, part, projections).board_time);
  };
  const bool filtered = std::holds_alternative<FdkSettings>(what.method);
  const Case less = a_part_of(what, 2, 1), more = a_part_of(what, filtered ? 4 : 2, 2);
  double over = 0;
  for (const auto& [fidelity, sign] : {std::pair{"cycle", 1.0}, {"functional", -1.0}}) {
    over += sign * (time(more, fidelity) - time(less, fidelity)) / 2;
  }
  return known->second = std::max(0.0, over);
}

Reconstruction Runner::reconstruct(const Case& what) {
  Board board = open("functional", what.settings);
  return made_of(board, what, projections_of(what));
}

Outcome Runner::run(const Case& what) {
  Outcome out;
  const Projections projections = projections_of(what);
  {
    Board board = open("functional", what.settings);
    const Counters before = board.counters();
    out.made = made_of(board, what, projections);
    out.bus_ms = bus_ms(board.counters() - before);
  }
  double over = rays_over_bus_ms(what);
  if (!std::holds_alternative<FdkSettings>(what.method)) {  // and once the splatted weights
    Case weights = what;
    FdkSettings once = kPlainFdk;
    once.step = std::get<AlgebraicSettings>(what.method).step;
    weights.method = once;
    over = over * static_cast<double>(out.made.residuals.size()) + rays_over_bus_ms(weights);
  }
  out.board_ms = to_ms(out.made.board_time) + static_cast<double>(what.geometry.angles.size()) * over;
  const std::vector<float> truth = voxels(what.phantom, what.geometry.volume);
  out.error = compare(what.geometry.volume, out.made.values, truth, what.field);
  return out;
}

void charts(const ChartOptions& options, ProgressLine& progress) {
  Runner runner(options.board);
  const std::vector<Chart> all = cone_beam_charts();
  if (!options.point.empty()) {
    for (const Chart& chart : all) {
      for (const Series& series : chart.series) {
        const auto point = std::ranges::find(series.points, options.point, &Point::name);
        if (point != series.points.end()) return fmt::print("{}{}", header_of(chart), rows_of(*point, series, runner));
      }
    }
    throw InputError("--point", "a point of a chart's table", in_quotes(options.point));
  }
  for (const std::string& name : options.only) {
    if (std::ranges::find(all, name, &Chart::name) != all.end()) continue;
    std::string names;
    for (const Chart& chart : all) names += (names.empty() ? "" : ", ") + chart.name;
    throw InputError("--only", names, in_quotes(name));
  }
  for (const Chart& chart : all) {
    const auto& only = options.only;
    const bool wanted = only.empty() || std::ranges::find(only, chart.name) != only.end();
    if (wanted) write_chart(chart, options.folder, runner, progress);
  }
}

Phantom chart_head(double radius) {
  Phantom head = high_contrast_shepp_logan(radius);
  for (Ellipsoid& part : head) part.value *= 0.05;
  return head;
}

Phantom chart_discs() {
  Phantom discs;
  for (int i = -3; i <= 3; ++i) discs.push_back({0.05, {36, 36, 2}, {0, 0, 11.0 * i}, 0});
  return discs;
}

ConeGeometry chart_scan(int voxels, int pixels, int views) {
  return {.source_to_axis = 400,
          .source_to_detector = 800,
          .detector = {pixels, pixels, 200.0 / pixels, 200.0 / pixels},
          .volume = {{voxels, voxels, voxels}, (90.0 / voxels) * Vec3{1, 1, 1}},
          .angles = even_angles(views, 0.1, 2 * std::numbers::pi)};
}

Series case_series(const std::string& title, const std::string& prefix, const std::vector<double>& xs,
                   const std::function<Case(double x)>& case_at) {
  Series series{title, {}};
  for (const double x : xs) {
    series.points.push_back(
        {fmt::format("{}/{:g}", prefix, x), [what = case_at(x), x](Runner& runner) {
           const auto [made, error, board_ms, bus_ms] = runner.run(what);
           const double residual = made.residuals.empty() ? 0 : made.residuals.back();
           return fmt::format("{:g},{:.5g},{:.4g},{:.5g},{:.4g},{:.4g},{:.1f},{:.1f},{},{},{:.4g},{:.4g},{},{}\n", x,
                              error.rmse, error.bias, error.relative_l2, error.psnr, error.ssim, board_ms, bus_ms,
                              made.rays, made.deposits, made.clipped, residual, made.iterations, made.diverged ? 1 : 0);
         }});
  }
  return series;
}

}  // namespace gicube::samples
