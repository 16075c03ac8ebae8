// --max-error, --time-budget and --explain, as the programs share them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "gicube/time.h"

namespace gicube::samples {

struct PlanOptions {
  double max_error = 0;         // relative; 0: not asked for
  Picoseconds time_budget = 0;  // 0: not asked for
  bool explain = false;

  bool wanted() const { return max_error > 0 || time_budget > 0; }
};

// `what` a time budget is for: "a picture".
void add_plan_options(CLI::App& app, PlanOptions& options, const std::string& what);

// Throws UsageError: both targets at once, or --explain without one.
void check_plan(const PlanOptions& options);

// What --explain prints: lines of a plan, its headlines at the margin and what they head further in.
void print_plan(const std::vector<std::string>& lines);

// "1%" or "0.01". "20ms", "1.5s" or "300us". Throw CLI::ValidationError naming `option`.
double parse_share(const std::string& option, const std::string& text);
Picoseconds parse_duration(const std::string& option, const std::string& text);

}  // namespace gicube::samples
