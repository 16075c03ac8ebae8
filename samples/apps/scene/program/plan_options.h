// --max-error, --time-budget and --explain, which several programs have.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gicube/plan_text.h"
#include "gicube/time.h"
#include "scene/program/board_options.h"

namespace gicube::samples {

struct PlanOptions {
  double max_error = 0;         // relative; 0: not given
  Picoseconds time_budget = 0;  // 0: not given
  bool explain = false;

  bool wanted() const { return max_error > 0 || time_budget > 0; }
  PlanTarget target() const { return {max_error, time_budget}; }
};

// `what`: the subject of the time budget, such as "a picture".
void add_plan_options(CLI::App& app, PlanOptions& options, const std::string& what);

// Throws UsageError: both targets, or --explain without one.
void check_plan(const PlanOptions& options);

// Throws UsageError if `option`, which a plan chooses itself, was given too.
void refuse_with_plan(const CLI::App& app, const std::string& option);

// A time budget needs a level that models time: `cycle`, unless a level is given.
BoardOptions board_for(const PlanOptions& plan, BoardOptions board);

// Prints the lines of --explain: headlines, and the indented lines below them.
void print_plan(const std::vector<std::string>& lines);

// Keys: max_error time_budget_ms (null: not given) kept.
nlohmann::ordered_json target_json(const PlanTarget& target, bool kept);

// "1%" or "0.01". "20ms", "1.5s" or "300us". Throw CLI::ValidationError naming `option`.
double parse_share(const std::string& option, const std::string& text);
Picoseconds parse_duration(const std::string& option, const std::string& text);

}  // namespace gicube::samples
