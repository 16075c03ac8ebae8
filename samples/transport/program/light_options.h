// The options of gicube-path and gicube-photon-map.
#pragma once

#include <ostream>
#include <utility>

#include "scene/program/board_options.h"
#include "scene/program/option_group.h"
#include "transport/program/light_input.h"

namespace gicube::samples {

// What both are asked for, and their methods' settings.
template <class Settings>
struct LightOptions {
  LightInput light;
  Settings settings;
  int passes = 0;
  BoardOptions board;
};

// The options from a command line whose application is `app`; `add` adds those of the method. Nothing if help or the version was asked for
// and went to `out`. Throws UsageError with one line.
template <class Options, class Add>
std::optional<Options> parse_light_options(CLI::App& app, int passes, const Add& add, int argc, const char* const* argv,
                                           std::ostream& out) {
  Options options;
  options.passes = passes;
  app.footer("Exit codes: 0 done, 1 failed, 2 wrong usage. Method, limits and figures: docs/guide/light_paths.md.");
  add_light_input(app, options.light);
  OptionGroup method(app, "Method");
  add(method, options);
  add_board_options(app, options.board);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  check(options.light);
  options.settings.step = options.light.step;
  options.settings.seed = options.board.seed;
  return options;
}

}  // namespace gicube::samples
