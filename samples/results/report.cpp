#include "results/report.h"

#include <fmt/format.h>

#include <string>

#include "common/image_file.h"

namespace gicube::samples::results {
namespace {

constexpr auto kSections = {scenes_section,   bounds_section,   baseline_section, partition_section,
                            gains_section,    speed_up_section, scaling_section,  cache_section,
                            sampling_section, bus_section,      cost_section,     parameters_section};

std::string introduction(const Design& design) {
  return fmt::format(
      "# Results\n\n"
      "What the paper reports beside what our board does, rendering only. Everything here is made by one command and "
      "nothing is typed in:\n\n"
      "    script/results\n\n"
      "It runs `gicube-results` (samples/results), which measures on emulated boards at the cycle level through the "
      "public driver. Design point unless noted: volume {0}^3, blocks {1}^3, 4 processors, queues of 256 rays, 100 "
      "MHz, four "
      "RDRAMs, image {2}^2, half-voxel steps, rays done at an opacity of 0.98. Not measured yet, "
      "with issue: global illumination: rows 3, 4 and 18, and of rows 1, 2, 5 and 6 the half that needs light rays.\n\n"
      "## Paper and ours\n\n",
      design.edge, design.block(), design.image);
}

}  // namespace

void write_report(const ReportOptions& options) {
  Runs runs(options.jobs, options.quiet);
  Page page;
  for (;;) {
    page = Page();
    Bench bench(options.design, runs, page);
    for (const auto section : kSections) section(bench);
    if (runs.complete()) break;
    runs.measure();
  }
  const std::filesystem::path folder = options.folder / "results";
  std::filesystem::create_directories(folder);
  Bench bench(options.design, runs, page);
  for (const Run& run : bench.oblique()) {
    write_png(bench.get(run).image, folder / ("scene-" + name_of(run.scene) + ".png"), background_of(run.scene));
  }
  page.write_files(folder);
  write_text(options.folder / "RESULTS.md", introduction(options.design) + page.claims() + page.body());
}

}  // namespace gicube::samples::results
