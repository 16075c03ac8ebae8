// gicube-form-factors: radiosity in volumes, and visibility between voxels, by a GI-Cube board.
#include <iostream>

#include "form_factors/program/charts.h"
#include "form_factors/program/solve.h"
#include "form_factors/program/visibility.h"
#include "scene/program/program.h"
#include "scene/program/progress.h"

namespace {

using namespace gicube::samples;

int run(int argc, char** argv) {
  const auto options = parse_form_factor_options(argc, argv, std::cout);
  if (!options) return 0;
  if (const auto* wanted = std::get_if<SolveOptions>(&*options)) {
    for (const auto* file : {&wanted->factors, &wanted->solution, &wanted->picture, &wanted->board.stats}) {
      check_folder(*file);
    }
    ProgressLine progress(!wanted->board.quiet);
    solve(*wanted, progress);
  } else if (const auto* drawn = std::get_if<FormFactorChartOptions>(&*options)) {
    ProgressLine progress(!drawn->board.quiet);
    form_factor_charts(*drawn, progress);
  } else {
    const auto& looked = std::get<VisibilityOptions>(*options);
    check_folder(looked.board.stats);
    ProgressLine progress(!looked.board.quiet);
    visibility(looked, progress);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return run_program("gicube-form-factors", [&] { return run(argc, argv); });
}
