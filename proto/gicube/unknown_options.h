// Error messages for command-line options that a program does not have.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gicube {

// Returns the edit distance: the number of characters to insert, delete, replace or swap with a neighbour to turn one
// name into the other.
inline std::size_t edits_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, last, row(b.size() + 1);
  for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    before = std::move(last);
    last = row;
    row[0] = i;
    for (std::size_t j = 1; j < row.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row.back();
}

// Returns the first of the nearest names. It is empty if more than a third of every name is wrong, unless a name begins
// with the typed text.
inline std::string nearest_name(std::string_view typed, const std::vector<std::string>& names) {
  std::string nearest;
  std::size_t least = typed.size() / 3 + 1;
  for (const std::string& name : names) {
    const bool begins_so = typed.size() > 2 && name.starts_with(typed);
    const std::size_t edits =
        begins_so ? std::min<std::size_t>(1, name.size() - typed.size()) : edits_between(typed, name);
    if (edits < least) nearest = name, least = edits;
  }
  return nearest;
}

inline std::string joined(const std::vector<std::string>& words, const char* between) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

// Replaces the message of a CLI::App that has thrown a ParseError. Unknown options are listed in the order given, each
// with the nearest option. If an option received its numbers as separate words, the message shows how to write them.
// Otherwise it is the original message, with unexpected words in the order given. A negative number is not an option.
template <typename App>
std::string usage_fault(const App& app, const std::string& says) {
  std::vector<std::string> names;
  const auto add_names = [&names](const auto& of) {
    for (const auto* option : of.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  };
  add_names(app);
  for (const auto* command : app.get_subcommands()) add_names(*command);
  const std::vector<std::string> left = app.remaining(true);
  std::string options;
  for (const std::string& word : left) {
    const std::string typed = word.substr(0, word.find('='));
    if (typed.size() < 2 || typed[0] != '-' || typed == "--" || typed.find_first_of("0123456789.") == 1) continue;
    const std::string nearest = nearest_name(typed, names);
    options += (options.empty() ? "" : "; ") + typed + ": no such option" +
               (nearest.empty() ? "" : ", the nearest is " + nearest);
  }
  if (!options.empty()) return options;
  const std::string name = says.substr(0, says.find(": At Most 1 required"));
  const auto* option = name == says ? nullptr : app.get_option_no_throw(name);
  if (option != nullptr && option->get_type_name().find(',') != std::string::npos) {
    return name + ": expected " + option->get_type_name() + " without blanks, as " + name + " " +
           joined(option->results(), ",") + ", got " + joined(option->results(), " ");
  }
  return says.find("not expected") == std::string::npos ? says : "not expected: " + joined(left, " ");
}

}  // namespace gicube
