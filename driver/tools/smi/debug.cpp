// gicube-smi debug: lines to the board's debugger, and its answers.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>

#include "client.h"
#include "output.h"

namespace gicube::smi {

// Exit code 1 if a line of a script failed; the lines after it are executed nevertheless.
int debug(const Options& options) {
  std::ifstream file;
  const bool is_input = options.script_file == "-", asks = is_input && ::isatty(STDIN_FILENO) == 1;
  if (!is_input) {
    file.open(options.script_file);
    if (!file) throw UsageError(fmt::format("debug: expected a readable file, got {}", options.script_file));
  }
  std::istream& lines = is_input ? std::cin : file;
  bool has_fault = false;
  const auto next = [&]() -> std::optional<std::string> {
    if (asks) {
      fmt::print("(gicube) ");
      std::fflush(stdout);
    }
    std::string line;
    if (!std::getline(lines, line) || line == "detach" || line == "quit") return std::nullopt;
    if (!asks && !options.json) fmt::print("> {}\n", line);
    return line;
  };
  Client(options).debug(next, [&](const v1::DebugAnswer& answer) {
    has_fault = has_fault || answer.is_fault();
    if (options.json) {
      fmt::print("{}\n", to_json(answer).dump());  // one line per answer: readers take each before the next is sent
    } else {
      fmt::print("{}", answer.text());
    }
    std::fflush(stdout);
  });
  return has_fault && !asks ? 1 : 0;
}

}  // namespace gicube::smi
