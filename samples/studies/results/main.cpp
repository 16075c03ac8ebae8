// gicube-results: measures what the paper reports on emulated boards, and writes the page that puts both side by side.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <filesystem>
#include <iostream>
#include <thread>

#include "scene/image_file.h"
#include "scene/program/input_error.h"
#include "studies/results/bench.h"
#include "studies/results/report.h"

namespace {

using namespace gicube::samples;

constexpr int kFailed = 1, kWrongUsage = 2;  // exit codes

int run(int argc, char** argv) {
  results::ReportOptions options;
  options.jobs = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
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
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    std::cout << app.help();
    return 0;
  } catch (const CLI::CallForVersion& version) {
    std::cout << "gicube-results " << version.what() << '\n';
    return 0;
  } catch (const CLI::ParseError& error) {
    std::cerr << "gicube-results: " << error.what() << '\n';
    return kWrongUsage;
  }
  results::write_report(options);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "gicube-results: " << error.what() << '\n';
    return kFailed;
  }
}
