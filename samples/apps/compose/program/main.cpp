// gicube-compose: renders several volumes and surfaces in one picture with GI-Cube boards.
#include <iostream>

#include "compose/program/options.h"
#include "scene/program/program.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  return run_program("gicube-compose", [&] {
    const auto wanted = parse_compose_options(argc, argv, std::cout);
    if (!wanted) return 0;
    ProgressLine progress(!wanted->board.quiet);
    run(*wanted, progress);
    return 0;
  });
}
