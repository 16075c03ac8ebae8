#include <fmt/format.h>

#include <chrono>

#include "commands.h"
#include "diagnosis.h"
#include "gicube/board.h"
#include "json.h"
#include "table.h"

namespace gicube::smi {
namespace {

constexpr std::chrono::seconds kDoctorWatchdog{5};  // chosen: a healthy board answers within milliseconds

// A Unix path may have %XX in it; what is wrong with the rest of a URI the driver says.
std::string decoded(std::string_view text) {
  std::string path;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_code = text[i] == '%' && i + 2 < text.size() &&
                         std::isxdigit(static_cast<unsigned char>(text[i + 1])) &&
                         std::isxdigit(static_cast<unsigned char>(text[i + 2]));
    path += is_code ? static_cast<char>(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16)) : text[i];
    if (is_code) i += 2;
  }
  return path;
}

bool look_at_place(const std::string& uri, Diagnosis& diagnosis) {
  if (uri.starts_with("emu:")) return look_for_program(diagnosis);
  if (uri.starts_with("unix:") && uri.size() > 5) return look_at_socket(decoded(uri.substr(5)), diagnosis);
  if (uri.starts_with("tcp:") && uri.rfind(':') > 4) return look_at_port(uri.substr(4), diagnosis);
  return true;  // the driver says what a URI is
}

void try_to_open(const std::string& uri, Diagnosis& diagnosis) {
  const std::string question = "can it be opened?";
  OpenOptions options;
  options.watchdog = kDoctorWatchdog;
  try {
    const Board board = Board::open(uri, options);
    const BoardInfo& info = board.info();
    diagnosis.good(question, fmt::format("yes: protocol {}.{}, {} processors, configuration {:016x}",
                                         info.protocol_major, info.protocol_minor, info.processors, info.config_hash));
  } catch (const BoardBusy& error) {
    diagnosis.bad(question, error.what(),
                  "wait until its owner ends, or press its power button: gicube-smi reset -m ENDPOINT");
  } catch (const VersionMismatch& error) {
    diagnosis.bad(question, error.what(), "build driver and board from the same release");
  } catch (const TimedOut& error) {
    diagnosis.bad(question, error.what(), "something listens there that does not answer: is it a gicube-board?");
  } catch (const BadArgument& error) {
    diagnosis.bad(question, error.what(), "mend the URI");
  } catch (const Error& error) {
    diagnosis.bad(question, error.what(), "mend what it says; a board that listens also writes a log");
  }
}

void look_at_management(const Options& options, Diagnosis& diagnosis) {
  const std::string question = "what does the management plane say?";
  try {
    const v1::ListBoardsResponse boards = Client(options).list();
    std::string answer;
    for (const v1::BoardInfo& board : boards.boards()) {
      answer += fmt::format("{}board {} at {} is {}", answer.empty() ? "" : "; ", board.board(), board.bus_endpoint(),
                            board.in_use() ? "in use" : "free");
    }
    diagnosis.good(question, answer);
  } catch (const CallFailed& error) {
    diagnosis.bad(question, error.what(), "");
  }
}

// Lines after the first stand below it.
std::string indented(const std::string& text) {
  std::string lines;
  for (const char c : text) lines += c == '\n' ? std::string("\n        ") : std::string(1, c);
  return lines;
}

const char* mark_of(const Step& step) {
  switch (step.outcome) {
    case Step::Outcome::kGood: return "ok";
    case Step::Outcome::kBad: return "BAD";
    case Step::Outcome::kNote: return "note";
  }
  return "?";
}

}  // namespace

int doctor(const Options& options) {
  Diagnosis diagnosis;
  if (!options.management.empty()) look_at_management(options, diagnosis);
  if (look_at_place(options.uri, diagnosis)) try_to_open(options.uri, diagnosis);
  if (options.json) {
    nlohmann::ordered_json steps = nlohmann::ordered_json::array();
    for (const Step& step : diagnosis.steps()) {
      steps.push_back({{"question", step.question},
                       {"good", step.outcome != Step::Outcome::kBad},
                       {"answer", step.answer},
                       {"advice", step.advice}});
    }
    print({{"uri", options.uri}, {"healthy", diagnosis.healthy()}, {"steps", std::move(steps)}});
    return diagnosis.healthy() ? 0 : 1;
  }
  fmt::print("{}\n", options.uri);
  for (const Step& step : diagnosis.steps()) {
    fmt::print("  {:<4}  {} {}\n", mark_of(step), step.question, indented(step.answer));
    if (!step.advice.empty()) fmt::print("        -> {}\n", step.advice);
  }
  return diagnosis.healthy() ? 0 : 1;
}

}  // namespace gicube::smi
