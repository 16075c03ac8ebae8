// gicube-form-factors: radiosity in volumes, and visibility between voxels, with a GI-Cube board.
#include <iostream>

#include "form_factors/program/options.h"
#include "scene/program/program.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  return run_program("gicube-form-factors", [&] {
    const auto wanted = parse_form_factor_options(argc, argv, std::cout);
    const auto carry_out = [](const auto& options) {
      ProgressLine progress(!options.board.quiet);
      run(options, progress);
    };
    if (wanted) std::visit(carry_out, *wanted);
    return 0;
  });
}
