// gicube-cone-beam: cone-beam tomography with a GI-Cube board.
#include <malloc.h>

#include <iostream>

#include "cone_beam/program/options.h"
#include "scene/program/program.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  // Chosen: keeps the memory of a view, megabytes, for the next one.
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 128 << 20);
  return run_program("gicube-cone-beam", [&] {
    CLI::App app("Reconstruct volumes from cone-beam projections with a GI-Cube board.", "gicube-cone-beam");
    app.footer(
        "Exit codes: 0 done, 1 failed, 2 wrong usage. Method, formats, limits, figures: docs/guide/cone_beam.md.");
    app.set_version_flag("--version", std::string(GICUBE_VERSION));
    app.require_subcommand(1);
    for (const auto add : {add_project, add_reconstruct, add_compare, add_import}) add(app);
    parsed(app, argc, argv, std::cout);
    return 0;
  });
}
