#include "scene/program/plan_options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "scene/program/board_options.h"
#include "scene/program/option_group.h"

namespace gicube::samples {
namespace {

// The number at the beginning of the text, and the rest.
std::optional<std::pair<double, std::string>> split(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
  return std::pair{number, std::string(end, text.data() + text.size())};
}

}  // namespace

double parse_share(const std::string& option, const std::string& text) {
  const auto parts = split(text);
  if (parts && (parts->second.empty() || parts->second == "%")) {
    const double share = parts->second.empty() ? parts->first : parts->first / 100;
    if (share > 0 && share <= 1) return share;
  }
  throw CLI::ValidationError(option, "expected more than 0 and at most 1, or percent as 1%, got " + in_quotes(text));
}

Picoseconds parse_duration(const std::string& option, const std::string& text) {
  constexpr std::pair<const char*, double> kUnits[] = {{"us", 1e6}, {"ms", 1e9}, {"s", 1e12}};
  if (const auto parts = split(text)) {
    for (const auto& [unit, picoseconds] : kUnits) {
      const double duration = parts->first * picoseconds;
      if (parts->second == unit && duration >= 1 && duration < 1e18) return static_cast<Picoseconds>(duration);
    }
  }
  throw CLI::ValidationError(option, "expected a time as 20ms, 1.5s or 300us, got " + in_quotes(text));
}

void add_plan_options(CLI::App& app, PlanOptions& options, const std::string& what) {
  OptionGroup group(app, "Plan");
  group.parsed(
      "--max-error", "E", "the cheapest settings whose predicted error against the finest is at most E, as 1%",
      [&options](const std::string& name, const std::string& text) { options.max_error = parse_share(name, text); });
  group.parsed("--time-budget", "T", "the most accurate settings with " + what + " in this board time, as 20ms",
               [&options](const std::string& name, const std::string& text) {
                 options.time_budget = parse_duration(name, text);
               });
  group.flag("--explain", options.explain, "print the plan's choice, its predicted error and the cost that it saves");
}

void check_plan(const PlanOptions& options) {
  if (options.max_error > 0 && options.time_budget > 0) {
    throw UsageError("--max-error: expected it or --time-budget, got both");
  }
  if (options.explain && !options.wanted()) throw UsageError("--explain: expected --max-error or --time-budget too");
}

void refuse_with_plan(const CLI::App& app, const std::string& option) {
  if (app.get_option(option)->count() == 0) return;
  throw UsageError(option + ": expected none with --max-error and --time-budget, which choose it");
}

BoardOptions board_for(const PlanOptions& plan, BoardOptions board) {
  if (plan.time_budget > 0 && board.fidelity.empty() && board.board.starts_with("emu:") &&
      board.board.find("fidelity=") == std::string::npos) {
    board.fidelity = "cycle";
  }
  return board;
}

void print_plan(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) fmt::print("{}{}\n", line.starts_with("plan ") ? "" : "  ", line);
}

nlohmann::ordered_json target_json(const PlanTarget& target, bool kept) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["max_error"] = target.max_error > 0 ? Json(target.max_error) : Json(nullptr);
  json["time_budget_ms"] = target.time_budget > 0 ? Json(to_ms(target.time_budget)) : Json(nullptr);
  json["kept"] = kept;
  return json;
}

}  // namespace gicube::samples
