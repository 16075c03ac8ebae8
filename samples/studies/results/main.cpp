// gicube-measure: carries out the runs of gicube-results on emulated boards.
#include <CLI/CLI.hpp>
#include <iostream>

#include "gicube/parallel_for.h"
#include "scene/program/board_options.h"
#include "scene/program/program.h"
#include "studies/results/measure.h"

namespace {

using namespace gicube::samples;

int run(int argc, char** argv) {
  CLI::App app(
      "Reads runs from standard input, a JSON list for each board, and prints what each adds to the counters, a line "
      "of "
      "JSON as soon as it is measured.",
      "gicube-measure");
  unsigned jobs = gicube::thread_count(0);
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  app.add_option("--jobs", jobs, "boards at a time")->check(CLI::Range(1, 64))->capture_default_str();
  if (!parsed(app, argc, argv, std::cout)) return 0;
  const auto boards = results::Json::parse(std::cin).get<std::vector<std::vector<results::Run>>>();
  results::SceneStore scenes;
  std::mutex mutex;
  gicube::parallel_for(boards.size(), jobs, [&](std::size_t board) {
    results::measure(boards[board], scenes, [&](std::size_t run, results::Json result) {
      result["board"] = board;
      result["run"] = run;
      const std::lock_guard lock(mutex);
      std::cout << result << '\n' << std::flush;
    });
  });
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-measure", [&] { return run(argc, argv); });
}
