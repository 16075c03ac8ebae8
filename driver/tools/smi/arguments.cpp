#include "arguments.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string_view>

namespace gicube::smi {
namespace {

// "-n" of "-n10", "--count" of "--count=10".
std::string name_of(const std::string& word) {
  return word.starts_with("--") ? word.substr(0, word.find('=')) : word.substr(0, 2);
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

// Whether the next word is this option's value; an option has the same form in all commands.
bool wants_value(const CLI::App& app, const std::string& word) {
  const std::string name = name_of(word);
  if (name != word) return false;  // it has its value already
  if (const CLI::Option* option = app.get_option_no_throw(name)) return option->get_items_expected_max() > 0;
  return std::ranges::any_of(commands_of(app), [&](const CLI::App* command) { return wants_value(*command, word); });
}

}  // namespace

std::vector<std::string> command_first(const CLI::App& app, const std::vector<std::string>& words) {
  std::vector<std::string> commands, options;
  const CLI::App* command = &app;
  auto word = words.begin();
  while (word != words.end() && !commands_of(*command).empty()) {
    if (word->starts_with('-')) {
      const bool has_value = wants_value(app, *word);
      options.push_back(*word++);
      if (has_value && word != words.end()) options.push_back(*word++);
      continue;
    }
    const auto below = commands_of(*command);
    const auto named = std::ranges::find(below, *word, [](const CLI::App* each) { return each->get_name(); });
    if (named == below.end()) break;
    command = *named;
    commands.push_back(*word++);
  }
  std::vector<std::string> ordered = std::move(commands);
  ordered.insert(ordered.end(), options.begin(), options.end());
  ordered.insert(ordered.end(), word, words.end());
  return ordered;
}

// CLI::AsNumberWithUnit reads "ms" as 1ms, and refuses "20" with "Missing mandatory unit", without the expected and the
// given value.
std::chrono::milliseconds time_with_unit(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  const double milliseconds = unit == "ms" ? 1 : unit == "s" ? 1e3 : unit == "min" ? 60e3 : 0;
  constexpr double kLongest = 1e12;  // 30 years: more than is useful, without overflow
  const bool is_time = error == std::errc{} && value >= 0 && value * milliseconds < kLongest && milliseconds > 0;
  if (!is_time)
    throw std::invalid_argument(fmt::format("expected a time with its unit (ms, s, min), as 500ms, got {}", text));
  return std::chrono::milliseconds(std::llround(value * milliseconds));
}

}  // namespace gicube::smi
