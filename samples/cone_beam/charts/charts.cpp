#include "cone_beam/charts/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
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

void print_point(const std::string& name, Runner& runner) {
  for (const Chart& chart : cone_beam_charts()) {
    for (const Series& series : chart.series) {
      for (const Point& point : series.points) {
        if (point.name != name) continue;
        fmt::print("{}{}", header_of(chart), rows_of(point, series, runner));
        return;
      }
    }
  }
  throw InputError("--point", "a point of a chart's table", in_quotes(name));
}

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
  if (!options.point.empty()) return print_point(options.point, runner);
  const std::vector<Chart> all = cone_beam_charts();
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

}  // namespace gicube::samples
