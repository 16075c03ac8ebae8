#include <fmt/format.h>

#include <chrono>
#include <optional>

#include "checks.h"
#include "commands.h"
#include "json.h"
#include "table.h"

namespace gicube::smi {
namespace {

constexpr std::chrono::seconds kWatchdog{60};  // chosen: the cycle level needs some seconds for its picture

struct Result {
  std::string name;
  enum { kPass, kFail, kSkipped } outcome;
  std::string details;
};

const char* word_of(const Result& result) {
  return result.outcome == Result::kPass ? "pass" : result.outcome == Result::kFail ? "FAIL" : "skipped";
}

const char* name_of(Fidelity fidelity) {
  switch (fidelity) {
    case Fidelity::kFunctional: return "functional";
    case Fidelity::kApproximate: return "approximate";
    case Fidelity::kCycle: return "cycle";
  }
  return "?";
}

std::string one_line(std::string text) {
  for (char& c : text) c = c == '\n' ? ' ' : c;
  return text;
}

std::vector<Result> run_all(const std::string& uri) {
  std::vector<Result> results;
  std::optional<Board> board;
  try {
    OpenOptions options;
    options.watchdog = kWatchdog;
    board.emplace(Board::open(uri, options));
    const BoardInfo& info = board->info();
    results.push_back({"open", Result::kPass,
                       fmt::format("{} level, {} processors, volumes to {}^3, protocol {}.{}", name_of(info.fidelity),
                                   info.processors, info.max_volume_voxels, info.protocol_major, info.protocol_minor)});
  } catch (const Error& error) {
    results.push_back({"open", Result::kFail, one_line(error.what())});
  }
  bool lost = !board;
  for (const Check& check : checks()) {
    if (lost) {
      results.push_back({check.name, Result::kSkipped, "there is no board"});
      continue;
    }
    try {
      results.push_back({check.name, Result::kPass, check.run(*board)});
    } catch (const DeviceLost& error) {
      results.push_back({check.name, Result::kFail, one_line(error.what())});
      lost = true;
    } catch (const TimedOut& error) {
      results.push_back({check.name, Result::kFail, one_line(error.what())});
      lost = true;
    } catch (const std::exception& error) {
      results.push_back({check.name, Result::kFail, one_line(error.what())});
    }
  }
  return results;
}

}  // namespace

int validate(const Options& options) {
  const std::vector<Result> results = run_all(options.uri);
  std::size_t passed = 0;
  for (const Result& result : results) passed += result.outcome == Result::kPass ? 1 : 0;
  const bool good = passed == results.size();
  if (options.json) {
    nlohmann::ordered_json tests = nlohmann::ordered_json::array();
    for (const Result& result : results) {
      tests.push_back({{"name", result.name}, {"result", word_of(result)}, {"details", result.details}});
    }
    print({{"uri", options.uri}, {"passed", good}, {"tests", std::move(tests)}});
    return good ? 0 : 1;
  }
  Table table({{"TEST"}, {"RESULT"}, {"WHAT WAS SEEN"}});
  for (const Result& result : results) table.add({result.name, word_of(result), result.details});
  fmt::print("{}{} of {} tests passed\n", table.text(), passed, results.size());
  return good ? 0 : 1;
}

}  // namespace gicube::smi
