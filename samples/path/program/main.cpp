// gicube-path: bidirectional path tracing in a volume by a GI-Cube board.
#include <iostream>

#include "path/program/options.h"
#include "scene/program/program.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  return run_program("gicube-path", [&] {
    const auto options = parse_path_options(argc, argv, std::cout);
    if (!options) return 0;
    ProgressLine progress(!options->board.quiet);
    run(*options, progress);
    return 0;
  });
}
