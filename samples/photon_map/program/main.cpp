// gicube-photon-map: photon mapping in a volume by a GI-Cube board.
#include <iostream>

#include "photon_map/program/options.h"
#include "scene/program/program.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  return run_program("gicube-photon-map", [&] {
    const auto options = parse_photon_options(argc, argv, std::cout);
    if (!options) return 0;
    ProgressLine progress(!options->board.quiet);
    run(*options, progress);
    return 0;
  });
}
