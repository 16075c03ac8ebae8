#include "cone_beam/charts/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <numbers>
#include <sstream>

#include "scene/formats/whole_file.h"
#include "scene/program/input_error.h"

namespace gicube::samples {
namespace {

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
