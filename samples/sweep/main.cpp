// gicube-sweep: gicube-render over a grid of parameters, cost against error.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <map>
#include <ranges>
#include <set>
#include <vector>

#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/names.h"
#include "scene/program/board_options.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "scene/program/run_json.h"
#include "sweep/options.h"
#include "sweep/picture.h"
#include "sweep/run.h"
#include "sweep/table.h"

namespace {

using namespace gicube::samples;
using namespace gicube::samples::sweep;

constexpr const char* kPicture = "picture";
constexpr std::uintmax_t kMaxPictureMib = 64;  // chosen: of a chart

struct Pair {
  Point point;
  Run run, reference;
};

std::vector<Pair> pairs_of(const SweepOptions& options) {
  std::vector<Pair> pairs;
  for (const Point& point : grid(options.parameters)) {
    const Point all = changed(point, options.fixed);
    pairs.push_back({point, {arguments(all)}, {arguments(changed(all, options.reference))}});
  }
  return pairs;
}

// Each once, in order: points, then references.
std::vector<Run> runs_of(const std::vector<Pair>& pairs, bool with_references) {
  std::vector<Run> runs;
  for (const Pair& pair : pairs) runs.push_back(pair.run);
  if (with_references) std::ranges::transform(pairs, std::back_inserter(runs), &Pair::reference);
  std::set<std::string> known;
  std::erase_if(runs, [&](const Run& run) { return !known.insert(run.key()).second; });
  return runs;
}

double relative(double value, double reference) {
  return reference == 0 ? std::abs(value) : std::abs(value / reference - 1);
}

// It stands beside this program.
std::filesystem::path render_program() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "gicube-render";
}

// Runs what FOLDER/runs does not have yet, and works out costs and errors. Throws RunFailed, FileError, InputError (a figure that a
// run does not have).
Table run_sweep(const SweepOptions& options, ProgressLine& progress) {
  const RunFolder folder(options.folder / "runs");
  const std::vector<Pair> pairs = pairs_of(options);
  const bool one_picture = !options.reference_picture.empty();
  const std::vector<Run> runs = runs_of(pairs, !one_picture);
  carry_out_all(folder, runs, render_program(), options.jobs,
                [&](std::size_t done) { progress.show(fmt::format("{} of {} runs", done, runs.size())); });

  Table table{options.cost, options.error, options.also, {}};
  for (const std::string& name : options.also_errors) table.also.push_back("error " + name);
  std::map<std::filesystem::path, Picture> references;  // used again and again
  for (const Pair& pair : pairs) {
    const nlohmann::json statistics = folder.read(pair.run);
    Row row;
    row.point = pair.point;
    row.cost = figure(statistics, options.cost);
    row.command = pair.run.command();
    for (const std::string& name : options.also) row.also.push_back(figure_or_nan(statistics, name));
    row.is_reference = !one_picture && pair.run.key() == pair.reference.key();
    const nlohmann::json reference = one_picture ? nlohmann::json() : folder.read(pair.reference);
    for (const std::string& name : options.also_errors)
      row.also.push_back(relative(figure_or_nan(statistics, name), figure(reference, name)));
    if (options.error == kPicture) {
      const std::filesystem::path file = one_picture ? options.reference_picture : folder.picture(pair.reference);
      const auto [exact, fresh] = references.try_emplace(file);
      if (fresh) exact->second = read_picture(file);
      row.error = rmse(read_picture(folder.picture(pair.run)), exact->second);
    } else {
      row.error = relative(figure(statistics, options.error), figure(reference, options.error));
    }
    table.rows.push_back(std::move(row));
  }
  mark_front(table.rows);
  return table;
}

// Runs the gnuplot script. gnuplot does not say that a disk is full: a picture that does not end is none.
void draw(const SweepOptions& options, const std::string& base) {
  const std::filesystem::path part = base + ".svg.part";
  const std::string into = fmt::format("picture = '{}'", part.filename().string());
  std::string svg;
  try {
    run_to_end("gnuplot", {"-e", into, options.name + ".gp"}, base + ".log", options.folder);
    svg = read_text(part, "a picture by gnuplot", kMaxPictureMib);
  } catch (...) {
    std::filesystem::remove(part);
    throw;
  }
  std::filesystem::remove(part);
  if (!gicube::scene::trimmed(svg).ends_with("</svg>")) {
    throw gicube::scene::FileError(base + ".svg", "file", "a place to write to", "a part of the picture");
  }
  write_whole(base + ".svg", svg);
}

// CSV, JSON, the gnuplot script, and with `chart` its picture. Throws FileError; RunFailed if gnuplot fails.
void write_files(const SweepOptions& options, const Table& table) {
  const std::string base = (options.folder / options.name).string();
  write_whole(base + ".csv", csv(table));
  write_json(nlohmann::ordered_json::parse(json(table)), this_run(), base + ".json");
  write_whole(base + ".gp", chart(table, options.name, options.title.empty() ? options.name : options.title));
  if (options.chart) draw(options, base);
}

void print_front(const Table& table) {
  fmt::print("{:>12}  {:>12}  of {} runs, no other is cheaper and better:\n", table.cost, "error", table.rows.size());
  std::vector<Row> front;
  std::ranges::copy_if(table.rows, std::back_inserter(front), &Row::on_front);
  std::ranges::sort(front, {}, &Row::cost);
  for (const Row& row : front) fmt::print("{:12.6g}  {:12.6g}  {}\n", row.cost, row.error, row.command);
}

// A functional board counts no time of the ASIC: frame times are those of the bus and the DSP, which most parameters of the sampling do
// not change. Says so of each parameter that was varied in vain.
void warn_of_constant_cost(const SweepOptions& options, const Table& table) {
  constexpr double kHardly = 0.02;  // chosen: less than frame times of the approximate level are off by
  const auto varied = [](const Parameter& parameter) { return parameter.values.size() > 1; };
  const RunFolder folder(options.folder / "runs");
  const auto functional = [&](const Pair& pair) { return folder.read(pair.run).at("fidelity") == "functional"; };
  if (options.cost != "frame_ms" || !std::ranges::all_of(pairs_of(options), functional)) return;
  for (const Parameter& parameter : options.parameters | std::views::filter(varied)) {
    const double change = cost_change(table, parameter.name);
    if (change >= kHardly) continue;
    fmt::print(
        stderr,
        "gicube-sweep: note: {} changes frame_ms by at most {:.2g}%: at the functional level the ASIC takes no time. "
        "--fix fidelity=approximate counts it\n",
        parameter.name, 100 * change);
  }
}

int run(int argc, char** argv) {
  const auto options = parse_sweep_options(argc, argv, std::cout);
  if (!options) return 0;
  Table table;
  {
    ProgressLine progress(!options->quiet);
    table = run_sweep(*options, progress);
  }
  write_files(*options, table);
  if (options->quiet) return 0;
  warn_of_constant_cost(*options, table);
  print_front(table);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-sweep", [&] { return run(argc, argv); });
}
