// gicube-light: computes the light in a volume with host rays of a GI-Cube board.
#include <iostream>

#include "light/program/methods.h"
#include "scene/program/board_options.h"
#include "scene/program/program.h"

using namespace gicube::samples;

int main(int argc, char** argv) {
  return run_program("gicube-light", [&] {
    CLI::App app("Compute light paths in a volume with rays traced by a GI-Cube board.", "gicube-light");
    app.footer("Exit codes: 0 done, 1 failed, 2 wrong usage. Methods, limits and figures: docs/guide/light_paths.md.");
    app.set_version_flag("--version", std::string(GICUBE_VERSION));
    app.require_subcommand(1);
    for (const auto add : {add_path, add_photon_map}) add(app);
    parsed(app, argc, argv, std::cout);
    return 0;
  });
}
