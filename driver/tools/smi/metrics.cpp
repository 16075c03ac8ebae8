#include "metrics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

namespace gicube::smi {
namespace {

using Labels = std::vector<std::pair<std::string, std::string>>;

// One metric. The format requires its samples in one group.
struct Family {
  std::string type, help;
  std::vector<std::pair<Labels, std::string>> samples;
};
using Families = std::map<std::string, Family>;

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '\\' ? "\\\\" : c == '"' ? "\\\"" : c == '\n' ? "\\n" : std::string(1, c);
  return out;
}

// Seconds, exactly: with twelve decimals for picoseconds.
std::string seconds_text(std::uint64_t picoseconds) {
  constexpr std::uint64_t kSecond = 1'000'000'000'000;
  std::string text = fmt::format("{}.{:012}", picoseconds / kSecond, picoseconds % kSecond);
  text.erase(text.find_last_not_of('0') + 1);
  return text.ends_with('.') ? text + '0' : text;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, separator);) parts.push_back(part);
  return parts;
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// The position of the digits at the end.
std::size_t digits_of(const std::string& part) { return part.find_last_not_of("0123456789") + 1; }

// A counter as a metric of Prometheus.
struct Metric {
  std::string name, help, value;
  Labels labels;        // the numbers of numbered parts
  bool of_one = false;  // it counts for one of several equal parts of the board: processor0, not processor
};

// The unit of all clocks is cycles; the help text has the clock.
std::string plural(const std::string& unit) {
  const std::string noun = lower(unit.substr(unit.rfind(' ') + 1));
  return noun == "clock" || noun.ends_with("cycle") ? "cycles" : noun + 's';
}

// Nothing for counters of single milliseconds: Prometheus keeps the course in time itself.
std::optional<Metric> metric_of(const v1::Counter& counter) {
  constexpr std::string_view kPicoseconds = "_ps";
  Metric metric{"gicube", "", std::to_string(counter.value()), {}, false};
  std::string last, name = counter.name();
  const bool is_time = counter.unit() == "ps";
  if (is_time && name.ends_with(kPicoseconds)) name.resize(name.size() - kPicoseconds.size());
  for (const std::string& part : split(name, '.')) {
    const std::size_t digits = digits_of(part);
    const std::string word = part.substr(0, digits);
    if (word == "ms" && digits < part.size()) return std::nullopt;
    if (last.empty()) metric.of_one = digits < part.size();
    if (digits < part.size()) {  // processor0; or the 3 of samples_with_misses.3, a number of the word before
      metric.labels.emplace_back(word.empty() ? last.substr(last.rfind('_') + 1) : word, part.substr(digits));
    }
    if (!word.empty()) metric.name += '_' + lower(word);
    metric.help += (metric.help.empty() ? "" : ".") + (digits < part.size() ? word + 'N' : part);
    last = part;
  }
  std::ranges::replace_if(
      metric.name, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  const std::string unit = is_time ? "seconds" : plural(counter.unit());
  const std::vector<std::string> words = split(metric.name, '_');
  if (std::ranges::find(words, unit) == words.end()) metric.name += '_' + unit;
  metric.name += "_total";
  metric.help = is_time ? fmt::format("Counter {}_ps, simulated time in seconds.", metric.help)
                        : fmt::format("Counter {}, unit: {}.", metric.help, counter.unit());
  if (is_time) metric.value = seconds_text(counter.value());
  return metric;
}

void add(Families& families, const std::string& name, const char* type, const std::string& help, Labels labels,
         std::string value) {
  Family& family = families[name];
  if (family.type.empty()) {
    family.type = type;
    family.help = help;
  }
  family.samples.emplace_back(std::move(labels), std::move(value));
}

void add_counters(Families& families, const Labels& board, const v1::CounterSnapshot& snapshot) {
  std::vector<Metric> metrics;
  std::set<std::string> divided;
  for (const v1::Counter& counter : snapshot.counters()) {
    std::optional<Metric> metric = metric_of(counter);
    if (!metric) continue;
    if (metric->of_one) divided.insert(metric->name);
    metrics.push_back(std::move(*metric));
  }
  for (Metric& metric : metrics) {
    // A sum is left out, since queries that add up the parts would count it twice.
    if (!metric.of_one && divided.contains(metric.name)) continue;
    Labels labels = board;
    labels.insert(labels.end(), metric.labels.begin(), metric.labels.end());
    add(families, metric.name, "counter", metric.help, std::move(labels), std::move(metric.value));
  }
}

void add_boards(Families& families, const Labels& process, const v1::BoardProcess& told) {
  for (int i = 0; i < told.boards_size(); ++i) {
    const v1::BoardInfo& board = told.boards(i);
    Labels labels = process;
    labels.emplace_back("board", std::to_string(board.board()));
    Labels facts = labels;
    facts.insert(facts.end(), {{"endpoint", board.bus_endpoint()},
                               {"fidelity", v1::FidelityLevel_Name(board.config().fidelity())},
                               {"bus", v1::BusModel_Name(board.config().bus().model())},
                               {"configuration", board.config_hash()},
                               {"version", board.version()}});
    add(families, "gicube_board_info", "gauge", "What a board is; always 1.", std::move(facts), "1");
    add(families, "gicube_board_in_use", "gauge", "1 while a session owns the board.", labels,
        board.in_use() ? "1" : "0");
    if (i >= told.counters_size()) continue;
    add(families, "gicube_board_simulated_seconds_total", "counter", "Simulated time since the board's reset.", labels,
        seconds_text(told.counters(i).simulated_ps()));
    add_counters(families, labels, told.counters(i));
  }
}

// Name and description of a quota. One of another version's process keeps its own name.
std::pair<std::string, std::string> quota_metric(const std::string& name) {
  static const std::map<std::string, std::string> kKnown{
      {"connections", "connections that own no board."},
      {"memory_bytes", "memory of the host's for volume, words and image."},
      {"results_bytes", "memory of the host's for what a client has not fetched."}};
  const auto known = kKnown.find(name);
  if (known != kKnown.end()) return *known;
  std::string plain = name;
  std::ranges::replace_if(
      plain, [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return {plain, plain + "."};
}

}  // namespace

std::string metrics_text(const std::vector<LocalProcess>& processes) {
  Families families;
  for (const LocalProcess& process : processes) {
    const Labels labels{{"pid", std::to_string(process.pid)}};
    add(families, "gicube_process_up", "gauge", "1 if the board process answers.", labels, process.told ? "1" : "0");
    if (!process.told) continue;
    add_boards(families, labels, *process.told);
    for (const v1::AuditCount& each : process.told->events()) {
      Labels of_event = labels;
      of_event.emplace_back("event", each.event());
      add(families, "gicube_audit_events_total", "counter",
          "Connections, refusals, takeovers and changes, by the kinds of the audit log.", std::move(of_event),
          std::to_string(each.count()));
    }
    for (const v1::Quota& each : process.told->quotas()) {
      Labels of_board = labels;
      if (each.has_board()) of_board.emplace_back("board", std::to_string(each.board()));
      const auto [name, what] = quota_metric(each.name());
      add(families, "gicube_quota_" + name, "gauge", "Of the limit, taken now: " + what, of_board,
          std::to_string(each.used()));
      add(families, "gicube_quota_limit_" + name, "gauge", "The limit: " + what, of_board,
          std::to_string(each.limit()));
    }
  }
  std::string text;
  for (const auto& [name, family] : families) {
    text += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, family.help, name, family.type);
    for (const auto& [labels, value] : family.samples) {
      std::string list;
      for (const auto& [key, label] : labels) {
        list += fmt::format("{}{}=\"{}\"", list.empty() ? "" : ",", key, escaped(label));
      }
      text += fmt::format("{}{{{}}} {}\n", name, list, value);
    }
  }
  return text;
}

}  // namespace gicube::smi
