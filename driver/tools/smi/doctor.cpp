// gicube-smi doctor: why a board can't be opened, step by step, with advice.
#include <fmt/format.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include <boost/asio/error.hpp>

#include "client.h"
#include "gicube/board.h"
#include "output.h"
#include "transport/connect.h"
#include "transport/launch.h"
#include "transport/pci_devices.h"
#include "transport/uri.h"

namespace gicube::smi {
namespace {

namespace fs = std::filesystem;
using boost::system::error_code;

constexpr std::chrono::seconds kDoctorWatchdog{5};   // chosen: a healthy board answers within milliseconds
constexpr std::chrono::seconds kConnectPatience{3};  // chosen

struct Step {
  bool good;
  std::string question, answer;
  std::string advice;  // empty: none
};

// Findings, step by step. The functions below return whether the next step can succeed.
struct Diagnosis {
  std::vector<Step> steps;

  bool good(const std::string& question, const std::string& answer) {
    return steps.emplace_back(Step{true, question, answer, ""}).good;
  }
  bool bad(const std::string& question, const std::string& answer, const std::string& advice) {
    return steps.emplace_back(Step{false, question, answer, advice}).good;
  }
  bool healthy() const { return std::ranges::all_of(steps, &Step::good); }
};

std::string user_name(uid_t user) {
  const passwd* entry = ::getpwuid(user);
  return entry != nullptr ? entry->pw_name : std::to_string(user);
}

// The program's answer to --version; empty if it cannot be run.
std::string version_of(const fs::path& program) {
  std::string quoted = "'";
  for (const char c : program.string()) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(::popen((quoted + "' --version 2>&1").c_str(), "r"),
                                                             &::pclose);
  std::array<char, 200> line{};
  if (!pipe || std::fgets(line.data(), line.size(), pipe.get()) == nullptr) return {};
  std::string text(line.data());
  text.erase(text.find_last_not_of('\n') + 1);
  return text;
}

bool look_for_program(Diagnosis& diagnosis) {
  const std::string question = "is gicube-board there?";
  for (const fs::path& place : board_program_places()) {
    std::error_code error;
    if (!fs::exists(place, error)) continue;
    if (!fs::is_regular_file(place, error) || ::access(place.c_str(), X_OK) != 0) {
      return diagnosis.bad(question,
                           fmt::format("{} is not a program that {} may run", place.string(), user_name(::geteuid())),
                           fmt::format("chmod +x {}", place.string()));
    }
    const std::string version = version_of(place);
    if (version.find("gicube-board") == std::string::npos) {
      return diagnosis.bad(question,
                           fmt::format("{} does not run: {}", place.string(), version.empty() ? "no answer" : version),
                           "build or install it again");
    }
    return diagnosis.good(question, fmt::format("{} ({})", place.string(), version));
  }
  if (const char* named = named_board_program()) {
    return diagnosis.bad(question, fmt::format("GICUBE_BOARD names {}, which does not exist", named),
                         "set GICUBE_BOARD to the program, or unset it");
  }
  return true;  // the driver names all places that it searched
}

bool look_at_socket(const Uri& uri, Diagnosis& diagnosis) {
  const std::string start = "start a board: gicube-board --listen unix:" + uri.path;
  const std::string question = "is there a socket?";
  struct stat info {};
  if (::stat(uri.path.c_str(), &info) != 0) {
    if (errno != EACCES) {
      return diagnosis.bad(question, fmt::format("{}: {}", uri.path, std::strerror(errno)), start);
    }
    return diagnosis.bad(question,
                         fmt::format("a folder of {} may not be searched by {}", uri.path, user_name(::geteuid())),
                         "ask its owner for the right to search it");
  }
  if (!S_ISSOCK(info.st_mode)) {
    return diagnosis.bad(question, fmt::format("{} is something else", uri.path),
                         "name the path that gicube-board listens on");
  }
  diagnosis.good(question, fmt::format("{}, of {}, mode {:o}", uri.path, user_name(info.st_uid), info.st_mode & 0777));
  error_code error;
  try_to_connect(uri, kConnectPatience, error);
  if (!error) return diagnosis.good("does somebody listen?", "yes");
  if (error == boost::system::errc::permission_denied) {
    return diagnosis.bad(
        "may it be opened?", fmt::format("not by {}", user_name(::geteuid())),
        fmt::format("run as {}, or have the socket's mode changed: a board lets nobody but its owner in",
                    user_name(info.st_uid)));
  }
  const bool is_left = error == boost::asio::error::connection_refused;
  return diagnosis.bad("does somebody listen?",
                       is_left ? "nobody: the socket is left from a board that has ended" : error.message(), start);
}

bool look_at_port(const Uri& uri, const std::string& text, Diagnosis& diagnosis) {
  error_code error;
  try_to_connect(uri, kConnectPatience, error);
  const bool is_known = !error || error.category() == boost::system::system_category();
  const std::string question = "is the host known?";
  if (!is_known) return diagnosis.bad(question, fmt::format("{}: {}", uri.host, error.message()), "check its name");
  diagnosis.good(question, uri.host);
  if (!error) return diagnosis.good("does somebody listen?", fmt::format("yes, on port {}", uri.port));
  const std::string why = error == boost::asio::error::would_block ? std::strerror(ETIMEDOUT) : error.message();
  return diagnosis.bad("does somebody listen?", fmt::format("port {}: {}", uri.port, why),
                       error == boost::asio::error::connection_refused
                           ? "start a board there: gicube-board --listen tcp:" + text.substr(text.find(':') + 1) +
                                 (uri.is_secure ? " --tls-cert FILE --tls-key FILE" : "")
                           : "is the host up, and does a firewall let the port through?");
}

bool look_at_function(const Uri& uri, Diagnosis& diagnosis) {
  for (const auto& [holds, question, answer, advice] : pci_conditions(uri.path)) {
    if (!holds) return diagnosis.bad(question, answer, advice);
    diagnosis.good(question, answer);
  }
  return true;
}

bool look_at_place(const std::string& text, Diagnosis& diagnosis) {
  try {
    const Uri uri = parse_uri(text);
    switch (uri.scheme) {
      case UriScheme::kEmu: return look_for_program(diagnosis);
      case UriScheme::kUnix: return look_at_socket(uri, diagnosis);
      case UriScheme::kTcp: return look_at_port(uri, text, diagnosis);
      case UriScheme::kPci: return look_at_function(uri, diagnosis);
    }
  } catch (const BadArgument&) {  // the driver reports what is wrong with it
  }
  return true;
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
    diagnosis.bad(question, error.what(), "correct the URI");
  } catch (const Error& error) {
    diagnosis.bad(question, error.what(), "correct what the message names; a board that listens also writes a log");
  }
}

void look_at_management(const Options& options, Diagnosis& diagnosis) {
  const std::string question = "what does the management plane say?";
  try {
    const v1::ListBoardsResponse boards = Client(options).call(&Stub::ListBoards);
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

// Indents the lines after the first.
std::string indented(const std::string& text) {
  std::string lines;
  for (const char c : text) lines += c == '\n' ? std::string("\n        ") : std::string(1, c);
  return lines;
}

}  // namespace

int doctor(const Options& options) {
  Diagnosis diagnosis;
  if (!options.management.empty()) look_at_management(options, diagnosis);
  if (look_at_place(options.uri, diagnosis)) try_to_open(options.uri, diagnosis);
  if (options.json) {
    nlohmann::ordered_json steps = nlohmann::ordered_json::array();
    for (const auto& [good, question, answer, advice] : diagnosis.steps) {
      steps.push_back({{"question", question}, {"good", good}, {"answer", answer}, {"advice", advice}});
    }
    print({{"uri", options.uri}, {"healthy", diagnosis.healthy()}, {"steps", std::move(steps)}});
    return diagnosis.healthy() ? 0 : 1;
  }
  fmt::print("{}\n", options.uri);
  for (const auto& [good, question, answer, advice] : diagnosis.steps) {
    fmt::print("  {:<4}  {} {}\n", good ? "ok" : "BAD", question, indented(answer));
    if (!advice.empty()) fmt::print("        -> {}\n", advice);
  }
  return diagnosis.healthy() ? 0 : 1;
}

}  // namespace gicube::smi
