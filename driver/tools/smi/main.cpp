// gicube-smi: what boards there are, what they do, whether they work, and why one can't be opened.
//
// Exit codes: 0 good, 1 the answer is no or a call failed, 2 wrong usage.
#include <fmt/format.h>

#include <exception>

#include "commands.h"
#include "options.h"

namespace {

using namespace gicube::smi;

int run(const Options& options) {
  switch (options.command) {
    case Command::kList: return list(options);
    case Command::kInfo: return info(options);
    case Command::kTop: return top(options);
    case Command::kValidate: return validate(options);
    case Command::kReset: return reset(options);
    case Command::kFaults: return faults(options);
    case Command::kTrace: return trace(options);
    case Command::kDoctor: return doctor(options);
  }
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    std::string text;
    const auto options = parse_options(argc, argv, text);
    if (!options) {
      fmt::print("{}", text);
      return 0;
    }
    return run(*options);
  } catch (const UsageError& error) {
    fmt::print(stderr, "gicube-smi: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-smi: {}\n", error.what());
    return 1;
  }
}
