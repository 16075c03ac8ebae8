#include "scene/program/board_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <ranges>

#include "gicube/unknown_options.h"
#include "scene/common/checks.h"
#include "scene/program/option_group.h"
#include "scene/program/plan_options.h"

namespace gicube::samples {
namespace {

constexpr int kMaxThreads = 1024;                       // as the driver's URI option
constexpr std::uint32_t kMaxWatchdogSeconds = 604'800;  // chosen: a week

// The provenance of the process's only command line.
Provenance& last_run() {
  static Provenance run;
  return run;
}

// & ends an option of the URI and % starts an escape.
std::string percent_encoded(const std::string& text) {
  std::string encoded;
  for (const char c : text) encoded += c == '%' ? "%25" : c == '&' ? "%26" : std::string(1, c);
  return encoded;
}

template <typename Number>
std::vector<Number> split_numbers(const std::string& text, char separator) {
  std::vector<Number> numbers;
  for (const auto part : std::views::split(text, separator)) {
    const auto number = parse_number<Number>({part.begin(), part.end()});
    if (!number) return {};
    numbers.push_back(*number);
  }
  return numbers;
}

CLI::ValidationError bad_value(const std::string& option, const std::string& expected, const std::string& text) {
  return CLI::ValidationError(option, "expected " + expected + ", got " + in_quotes(text));
}

}  // namespace

Provenance this_run() { return last_run(); }

bool parsed(CLI::App& app, int argc, const char* const* argv, std::ostream& out) {
  last_run() = {.program = app.get_name(), .version = GICUBE_VERSION, .command = command_line(argc, argv)};
  try {
    app.parse(argc, argv);
    return true;
  } catch (const CLI::CallForHelp&) {
    out << app.help();
  } catch (const CLI::CallForVersion& version) {
    out << app.get_name() << ' ' << version.what() << '\n';
  } catch (const CLI::ParseError& error) {
    throw UsageError(usage_fault(app, error.what()));
  }
  return false;
}

void add_board_options(CLI::App& app, BoardOptions& options, bool several) {
  OptionGroup group(app, "Board and run");
  const std::string addresses =
      "emu: (a private emulated board), unix:PATH, tcp:HOST:PORT, tls:HOST:PORT or pci:ADDRESS";
  if (several) {
    const auto take = [&options](const std::vector<std::string>& texts) {
      options.board = texts.front();
      options.others.assign(texts.begin() + 1, texts.end());
    };
    app.add_option_function<std::vector<std::string>>("--board", take,
                                                      addresses + "; repeatable; emu:?boards=N are N boards  [emu:]")
        ->type_name("ADDRESS")
        ->expected(1)
        ->take_all()
        ->group("Board and run");
    group.flag("--own-buses", options.own_buses, "each of several boards has its own host bus, instead of sharing one");
  } else {
    group.value("--board", options.board, addresses)->capture_default_str();
  }
  group.value("--fidelity", options.fidelity, "fidelity level of the emulated board: functional or cycle");
  group.value("--config", options.config, "configuration of the emulated board (protobuf text)")
      ->check(CLI::ExistingFile);
  group.value("--set", options.settings, "one field of the configuration, such as asic.processors=8; repeatable")
      ->take_all()
      ->allow_extra_args(false)
      ->type_name("FIELD=VALUE");
  group.value("--stats", options.stats, "write the statistics of the frame as JSON")->type_name("FILE");
  group
      .value("--seed", options.seed,
             "seed of the random choices of scattered rays, recorded in the statistics; 0: the scene's seed")
      ->check(CLI::Validator(
          // CLI11 takes -1 for 2^64 - 1.
          [](const std::string& text) {
            return parse_number<std::uint64_t>(text)
                       ? ""
                       : "expected a whole number from 0 to 2^64 - 1, got " + in_quotes(text);
          },
          ""))
      ->capture_default_str();
  group
      .value("--threads", options.threads,
             "host threads for scene and emulator, 0 = one per core; results do not depend on it")
      ->check(CLI::Range(0, kMaxThreads))
      ->capture_default_str();
  group.parsed("--watchdog", "SECONDS", "fail if the board does not answer for this wall-clock time; 0 = never  [600]",
               [&options](const std::string& option, const std::string& text) {
                 const auto seconds = parse_number<std::uint32_t>(text);
                 if (!seconds || *seconds > kMaxWatchdogSeconds) {
                   throw bad_value(option, "whole seconds from 0 to " + std::to_string(kMaxWatchdogSeconds), text);
                 }
                 options.watchdog = std::chrono::seconds(*seconds);
               });
  group.flag("--quiet", options.quiet, "print only warnings and errors");
}

std::string board_uri(const BoardOptions& options) {
  if (!options.board.starts_with("emu:")) {
    const char* given = !options.fidelity.empty()   ? "--fidelity"
                        : !options.config.empty()   ? "--config"
                        : !options.settings.empty() ? "--set"
                                                    : nullptr;
    if (given != nullptr) {
      throw UsageError(std::string(given) + ": only for an emu: board; the running board at " + options.board +
                       " has its own configuration");
    }
    return options.board;
  }
  std::string uri = options.board;
  const auto add = [&uri](const char* name, const std::string& value) {
    const char* separator = uri.find('?') == std::string::npos         ? "?"
                            : uri.ends_with('?') || uri.ends_with('&') ? ""
                                                                       : "&";
    uri += separator + std::string(name) + '=' + percent_encoded(value);
  };
  if (!options.fidelity.empty()) add("fidelity", options.fidelity);
  if (!options.config.empty()) add("config", options.config.string());
  if (options.threads != 0) add("threads", std::to_string(options.threads));
  for (const std::string& setting : options.settings) add("set", setting);
  if (!options.events.empty()) add("events", options.events.string());
  if (!options.events.empty()) add("events_of", options.events_of);
  if (!options.restore.empty()) add("restore", options.restore.string());
  return uri;
}

std::vector<std::string> board_uris(const BoardOptions& options) {
  std::vector<std::string> uris{board_uri(options)};
  for (const std::string& other : options.others) {
    BoardOptions of_other = options;
    of_other.board = other;
    uris.push_back(board_uri(of_other));
  }
  return uris;
}

std::vector<double> parse_numbers(const std::string& option, const std::string& text, std::size_t count) {
  const std::vector<double> numbers = split_numbers<double>(text, ',');
  bool good = numbers.size() == count;
  for (const double number : numbers) good = good && std::isfinite(number);
  constexpr std::array kExamples{"1", "2,1", "1,0,0.5", "1,0,0.5,-3"};
  if (!good) {
    throw bad_value(
        option,
        fmt::format("{} numbers with commas between and no blanks, as {} {}", count, option, kExamples.at(count - 1)),
        text);
  }
  return numbers;
}

Vec3 parse_vector(const std::string& option, const std::string& text) {
  const std::vector<double> numbers = parse_numbers(option, text, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

std::vector<int> parse_sizes(const std::string& option, const std::string& text, std::size_t count, char separator) {
  const std::vector<int> numbers = split_numbers<int>(text, separator);
  bool good = numbers.size() == count;
  for (const int number : numbers) good = good && number >= 1;
  if (!good) throw bad_value(option, std::string(count == 2 ? "WxH" : "X,Y,Z") + ", whole numbers from 1", text);
  return numbers;
}

}  // namespace gicube::samples
