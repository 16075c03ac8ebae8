#include "view/options.h"

#include <CLI/CLI.hpp>

#include "scene/common/checks.h"

namespace gicube::samples::view {
namespace {

const char* const kFooter =
    "The address that is printed holds a token, and answers on this machine only. Ctrl-C ends the program.\n"
    "Exit codes: 0 ended, 1 failed, 2 wrong usage.";

}  // namespace

std::optional<ProgramOptions> parse_options(int argc, const char* const* argv, std::ostream& out) {
  ProgramOptions options;
  std::vector<std::string> fixed;
  CLI::App app("Shows volumes and scenes in the browser, and the board that makes their pictures.", "gicube-view");
  app.footer(kFooter);
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  app.add_option(
      "INPUT", options.view.inputs,
      "scenes and volumes as gicube-render takes them, builtin:buckyball; the first is shown, and files may be "
      "dropped on the page");
  app.add_option(
         "--fix", fixed,
         "an option of gicube-render without its dashes, as transfer-function=ct-bone (flags: on, off); repeatable")
      ->take_all()
      ->delimiter('\0')
      ->allow_extra_args(false)
      ->type_name("NAME=VALUE");
  app.add_option("--port", options.port, "of 127.0.0.1; 0 = any that is free")->capture_default_str();
  app.add_flag("--open,!--no-open", options.open, "show the page in the default browser (where there is a desktop)");
  add_board_options(app, options.view.board);
  app.remove_option(app.get_option("--stats"));  // the page has them
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  for (const std::string& text : fixed) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || text.front() == '-')
      throw UsageError("--fix: expected NAME=VALUE, the name without dashes, got " + in_quotes(text));
    options.view.settings[text.substr(0, equals)] = text.substr(equals + 1);
  }
  return options;
}

}  // namespace gicube::samples::view
