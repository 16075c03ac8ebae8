// gicube-cone-beam: cone-beam tomography by a GI-Cube board.
#include <iostream>

#include "cone_beam/program/commands.h"
#include "scene/program/program.h"

namespace {

using namespace gicube::samples;

int run(int argc, char** argv) {
  const auto options = parse_cone_beam_options(argc, argv, std::cout);
  if (!options) return 0;
  if (const auto* projected = std::get_if<ProjectOptions>(&*options)) project(*projected);
  if (const auto* wanted = std::get_if<ReconstructOptions>(&*options)) reconstruct(*wanted);
  if (const auto* compared = std::get_if<CompareOptions>(&*options)) compare(*compared);
  if (const auto* imported = std::get_if<ImportOptions>(&*options)) import(*imported);
  if (const auto* drawn = std::get_if<ChartOptions>(&*options)) {
    ProgressLine progress(!drawn->board.quiet);
    charts(*drawn, progress);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-cone-beam", [&] { return run(argc, argv); });
}
