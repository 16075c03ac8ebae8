// gicube-polygon-gi: light between polygons through a medium by a GI-Cube board.
#include <iostream>

#include "polygon_gi/program/options.h"
#include "scene/program/program.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  return run_program("gicube-polygon-gi", [&] {
    const auto options = parse_polygon_gi_options(argc, argv, std::cout);
    if (!options) return 0;
    ProgressLine progress(!options->board.quiet);
    run(*options, progress);
    return 0;
  });
}
