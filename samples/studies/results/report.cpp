#include "studies/results/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "scene/image_file.h"
#include "scene/text_file.h"

namespace gicube::samples::results {
namespace {

struct Section {
  const char* name;
  void (*write)(Bench& bench);
};

constexpr Section kSections[] = {{"scenes", scenes_section},
                                 {"bounds", bounds_section},
                                 {"baseline", baseline_section},
                                 {"illumination", illumination_section},
                                 {"light-sweep", light_sweep_section},
                                 {"block-loads", block_loads_section},
                                 {"lit-baseline", lit_baseline_section},
                                 {"partition", partition_section},
                                 {"gains", gains_section},
                                 {"speed-up", speed_up_section},
                                 {"scaling", scaling_section},
                                 {"cache", cache_section},
                                 {"sampling", sampling_section},
                                 {"bus", bus_section},
                                 {"cost", cost_section},
                                 {"parameters", parameters_section}};

bool asked_for(const ReportOptions& options, const Section& section) {
  return options.only.empty() ||
         std::find(options.only.begin(), options.only.end(), section.name) != options.only.end();
}

// The runs of which a picture is kept.
std::vector<Run> pictures(const Bench& bench) {
  std::vector<Run> runs = bench.oblique();
  for (const Run& run : bench.lit_scenes()) runs.push_back(run);
  return runs;
}

std::string introduction(const Design& design) {
  return fmt::format(
      "# Results\n\n"
      "What the paper reports beside what our board does. Everything here is made by one command and nothing is typed "
      "in:\n\n"
      "    script/results\n\n"
      "It runs `gicube-results` (samples/studies/results), which measures on emulated boards at the cycle level "
      "through the public driver. Design point unless noted: volume {0}^3, blocks {1}^3, 4 processors, queues of 256 "
      "rays, 100 MHz, four RDRAMs, image {2}^2, half-voxel steps, rays done at an opacity of 0.98.\n\n"
      "## Paper and ours\n\n",
      design.edge, design.block(), design.image);
}

}  // namespace

std::vector<std::string> section_names() {
  std::vector<std::string> names;
  for (const Section& section : kSections) names.emplace_back(section.name);
  return names;
}

void write_report(const ReportOptions& options) {
  Runs runs(options.jobs, options.quiet);
  Page page;
  for (;;) {
    page = Page();
    Bench bench(options.design, runs, page);
    for (const Section& section : kSections) {
      if (asked_for(options, section)) section.write(bench);
    }
    if (runs.complete()) break;
    runs.measure();
  }
  const std::filesystem::path folder = options.folder / "results";
  std::filesystem::create_directories(folder);
  Bench bench(options.design, runs, page);
  for (const Run& run : pictures(bench)) {
    const Image& image = bench.get(run).image;
    if (image.pixels.empty()) continue;  // none of the sections asked for it
    write_png(image, folder / ("scene-" + name_of(run.scene) + ".png"), background_of(run.scene));
  }
  page.write_files(folder);
  write_text(options.folder / "RESULTS.md", introduction(options.design) + page.claims() + page.body());
}

}  // namespace gicube::samples::results
