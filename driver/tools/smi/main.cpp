// gicube-smi: what boards there are, what they do, whether they work, and why one can't be opened.
//
// Exit codes: 0 good, 1 the answer is no or a call failed, 2 wrong usage.
#include <fmt/format.h>

#include <exception>

#include "options.h"

int main(int argc, char** argv) {
  using namespace gicube::smi;
  try {
    std::string text;
    if (const auto options = parse_options(argc, argv, text)) return options->run(*options);
    fmt::print("{}", text);
    return 0;
  } catch (const UsageError& error) {
    fmt::print(stderr, "gicube-smi: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-smi: {}\n", error.what());
    return 1;
  }
}
