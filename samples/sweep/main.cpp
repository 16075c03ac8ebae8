// gicube-sweep: gicube-render over a grid of parameters, cost against error.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <vector>

#include "scene/program/program.h"
#include "scene/program/progress.h"
#include "sweep/sweep.h"

namespace {

using namespace gicube::samples;
using namespace gicube::samples::sweep;
using gicube::samples::run_program;

// It stands beside this program.
std::filesystem::path render_program() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "gicube-render";
}

void print_front(const Table& table) {
  fmt::print("{:>12}  {:>12}  of {} runs, no other is cheaper and better:\n", table.cost, "error", table.rows.size());
  std::vector<Row> front;
  std::copy_if(table.rows.begin(), table.rows.end(), std::back_inserter(front),
               [](const Row& row) { return row.on_front; });
  std::sort(front.begin(), front.end(), [](const Row& a, const Row& b) { return a.cost < b.cost; });
  for (const Row& row : front) fmt::print("{:12.6g}  {:12.6g}  {}\n", row.cost, row.error, row.command);
}

int run(int argc, char** argv) {
  const auto options = parse_sweep_options(argc, argv, std::cout);
  if (!options) return 0;
  Table table;
  {
    ProgressLine progress(!options->quiet);
    table = sweep::sweep(*options, render_program(), [&](std::size_t done, std::size_t all) {
      progress.show(fmt::format("{} of {} runs", done, all));
    });
  }
  write_files(*options, table);
  if (!options->quiet) print_front(table);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-sweep", [&] { return run(argc, argv); });
}
