// gicube-results: measures what the paper reports on emulated boards, and writes the page that puts both side by side.
#include <CLI/CLI.hpp>
#include <iostream>

#include "scene/parallel.h"
#include "scene/program/board_options.h"
#include "scene/program/program.h"
#include "studies/results/report.h"

namespace {

using namespace gicube::samples;

int run(int argc, char** argv) {
  results::ReportOptions options;
  options.jobs = cores();
  CLI::App app("Measures the paper's results on emulated boards and writes RESULTS.md.", "gicube-results");
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  app.add_option("FOLDER", options.folder, "gets RESULTS.md, and its CSV files and gnuplot scripts in results/")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("--edge", options.design.edge, "voxels an edge of the volume, a power of two")
      ->check(CLI::IsMember({32, 64, 128, 256}))
      ->capture_default_str();
  app.add_option("--image", options.design.image, "pixels an edge of the image")
      ->check(CLI::Range(8, 1024))
      ->capture_default_str();
  app.add_option("--jobs", options.jobs, "boards at a time")->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--only", options.only, "sections to measure, for a page of these alone (all)")
      ->check(CLI::IsMember(results::section_names()))
      ->delimiter(',');
  app.add_flag("--quiet", options.quiet, "no progress");
  if (parsed(app, argc, argv, std::cout)) results::write_report(options);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-results", [&] { return run(argc, argv); });
}
