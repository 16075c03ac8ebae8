#include "sweep/sweep.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "sweep/picture.h"
#include "sweep/process.h"
#include "sweep/run.h"

namespace gicube::samples::sweep {
namespace {

constexpr const char* kPicture = "picture";

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
  std::set<std::string> known;
  const auto add = [&](const Run& run) {
    if (known.insert(run.key()).second) runs.push_back(run);
  };
  for (const Pair& pair : pairs) add(pair.run);
  if (with_references) {
    for (const Pair& pair : pairs) add(pair.reference);
  }
  return runs;
}

// Pictures of references are used again and again.
class Pictures {
 public:
  const Picture& of(const std::filesystem::path& file) {
    const auto known = pictures_.find(file);
    return known != pictures_.end() ? known->second : pictures_.emplace(file, read_picture(file)).first->second;
  }

 private:
  std::map<std::filesystem::path, Picture> pictures_;
};

double relative(double value, double reference) {
  return reference == 0 ? std::abs(value) : std::abs(value / reference - 1);
}

}  // namespace

Table sweep(const SweepOptions& options, const std::filesystem::path& program, const SweepProgress& progress) {
  const RunFolder folder(options.folder / "runs");
  const std::vector<Pair> pairs = pairs_of(options);
  const bool one_picture = !options.reference_picture.empty();
  const std::vector<Run> runs = runs_of(pairs, !one_picture);
  carry_out_all(folder, runs, program, options.jobs, [&](std::size_t done) { progress(done, runs.size()); });

  Table table{options.cost, options.error, options.also, {}};
  for (const std::string& name : options.also_errors) table.also.push_back("error " + name);
  Pictures references;
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
      const Picture& exact = references.of(one_picture ? options.reference_picture : folder.picture(pair.reference));
      row.error = rmse(read_picture(folder.picture(pair.run)), exact);
    } else {
      row.error = relative(figure(statistics, options.error), figure(reference, options.error));
    }
    table.rows.push_back(std::move(row));
  }
  mark_front(table.rows);
  return table;
}

void write_files(const SweepOptions& options, const Table& table) {
  const std::filesystem::path base = options.folder / options.name;
  const auto with = [&](const char* extension) {
    std::filesystem::path file = base;
    return file += extension;
  };
  write(csv(table), with(".csv"));
  write(json(table), with(".json"));
  write(chart(table, options.name, options.title.empty() ? options.name : options.title), with(".gp"));
  if (!options.chart) return;
  run_program("gnuplot", {options.name + ".gp"}, with(".log"), options.folder);
}

}  // namespace gicube::samples::sweep
