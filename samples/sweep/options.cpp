#include "sweep/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ostream>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/names.h"
#include "scene/program/board_options.h"

namespace gicube::samples::sweep {
namespace {

const char* const kFooter =
    "A sweep that was killed goes on where it was when the same command is given again: runs that are done are kept "
    "in\n"
    "FOLDER/runs and not done again. Every run has --threads 1, unless --fix threads=N.\n"
    "Exit codes: 0 done, 1 failed, 2 wrong usage.\n\n"
    "  gicube-sweep builtin:buckyball --vary step=0.25,0.5,1,2 --vary jitter=off,on \\\n    --reference step=0.0625 "
    "--reference jitter=off --fix fidelity=approximate -o out";

// CLI11 would cut them at commas.
struct Texts {
  std::vector<std::string> inputs, vary, fix, reference;
};

void add_options(CLI::App& app, SweepOptions& options, Texts& texts) {
  const auto all = [](CLI::Option* option) { return option->take_all()->delimiter('\0')->allow_extra_args(false); };
  app.add_option("INPUT", texts.inputs, "scenes or volumes, as gicube-render takes them")->required();
  all(app.add_option("--vary", texts.vary,
                     "a parameter and its values, NAME=V,V...: an option of gicube-render without dashes (flags: on, "
                     "off) or a field of the board's configuration; repeatable: all combinations are run"))
      ->type_name("NAME=V,V...");
  all(app.add_option("--fix", texts.fix, "the same for every run"))->type_name("NAME=VALUE");
  CLI::Option* reference = all(app.add_option("--reference", texts.reference,
                                              "a run's reference is the same run with this in place; repeatable"))
                               ->type_name("NAME=VALUE");
  app.add_option("--reference-picture", options.reference_picture, "an EXR that all runs are compared with")
      ->excludes(reference)
      ->check(CLI::ExistingFile);
  app.add_option("--cost", options.cost, "a number of gicube-render's --stats: a name, or a JSON pointer")
      ->capture_default_str();
  app.add_option("--error", options.error,
                 "picture: root mean square difference; or a number as for --cost: relative difference")
      ->capture_default_str();
  all(app.add_option("--also", options.also, "further numbers as for --cost, as columns"))->type_name("FIGURE");
  all(app.add_option("--also-error", options.also_errors, "the same of further numbers' relative differences"))
      ->type_name("FIGURE");
  app.add_option("-o,--output", options.folder, "NAME.csv, NAME.json, NAME.gp and runs/ go there")
      ->type_name("FOLDER")
      ->required();
  app.add_option("--name", options.name, "of the files")->capture_default_str();
  app.add_option("--title", options.title, "of the chart");
  app.add_option("--jobs", options.jobs, "runs at once; 0 = one per core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_flag("--chart", options.chart, "draw NAME.svg by gnuplot");
  app.add_flag("--quiet", options.quiet, "only errors");
}

void check(const SweepOptions& options) {
  std::vector<std::string> names;
  for (const Parameter& parameter : options.parameters) names.push_back(parameter.name);
  for (const Setting& setting : options.fixed) names.push_back(setting.name);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end()) throw UsageError(*twice + ": expected once among INPUT, --vary and --fix, got it twice");
  for (const char* own : {"output", "stats", "quiet", "frames"}) {
    if (std::binary_search(names.begin(), names.end(), own))
      throw UsageError(std::string(own) + ": expected another parameter, it is the sweep's own");
  }
  const bool compares = !options.reference.empty() || !options.reference_picture.empty();
  if (!compares) throw UsageError("--reference or --reference-picture: expected one of them, got none");
  if (options.reference_picture.empty()) return;
  if (options.error != "picture")
    throw UsageError("--error: expected picture with --reference-picture, got " + in_quotes(options.error));
  if (!options.also_errors.empty())
    throw UsageError("--also-error: expected with --reference, got --reference-picture");
}

}  // namespace

std::optional<SweepOptions> parse_sweep_options(int argc, const char* const* argv, std::ostream& out) {
  SweepOptions options;
  Texts texts;
  CLI::App app("Runs gicube-render over a grid of parameters, and charts cost against error.", "gicube-sweep");
  app.footer(kFooter);
  app.set_version_flag("--version", std::string(GICUBE_VERSION));
  add_options(app, options, texts);
  if (!parsed(app, argc, argv, out)) return std::nullopt;
  try {
    options.parameters.push_back({"input", texts.inputs});
    for (const std::string& text : texts.vary) options.parameters.push_back(parse_parameter(text));
    for (const std::string& text : texts.fix) options.fixed.push_back(parse_setting(text));
    for (const std::string& text : texts.reference) options.reference.push_back(parse_setting(text));
  } catch (const InputError& error) {
    throw UsageError(error.what());
  }
  if (std::ranges::count(options.fixed, "threads", &Setting::name) == 0 &&
      std::ranges::count(options.parameters, "threads", &Parameter::name) == 0) {
    options.fixed.push_back({"threads", "1"});
  }
  check(options);
  return options;
}

}  // namespace gicube::samples::sweep
