// gicube-subsurface: a material's profile by a GI-Cube board, and a mesh that has it.
#include <iostream>

#include "scene/program/program.h"
#include "subsurface/program/options.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  return run_program("gicube-subsurface", [&] {
    const auto options = parse_subsurface_options(argc, argv, std::cout);
    if (!options) return 0;
    ProgressLine progress(!options->board.quiet);
    run(*options, progress);
    return 0;
  });
}
