// gicube-conformance: tests a board against the rules of docs/reference/protocol.md (docs/guide/conformance.md).
//
// Exit codes: 0 all cases that were run passed, 1 a case failed or there is no board, 2 wrong usage.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <set>
#include <string>

#include "case.h"
#include "gicube/error.h"
#include "gicube/unknown_options.h"
#include "gicube/whole_file.h"
#include "host.h"
#include "place.h"
#include "report.h"

namespace {

using namespace gicube;
using namespace gicube::conformance;

struct Options {
  std::string uri = "emu:", filter, junit_file;
  std::set<unsigned> classes;
  unsigned timeout_ms = 20'000;
  bool lists = false, stops = false, quiet = false;
};

std::vector<Case> chosen(const Options& options) {
  std::vector<Case> cases = all_cases();
  std::erase_if(cases, [&options](const Case& each) {
    return (!options.classes.empty() && !options.classes.contains(each.level)) ||
           std::string(each.name).find(options.filter) == std::string::npos;
  });
  return cases;
}

Outcome run(const Case& tested, Place& place) {
  Outcome outcome{tested, {}, 0};
  const auto begin = std::chrono::steady_clock::now();
  try {
    if (const auto* alone = std::get_if<void (*)(Place&)>(&tested.run)) {
      (*alone)(place);
    } else {
      Host host(place);
      std::get<void (*)(Host&)>(tested.run)(host);
    }
  } catch (const std::exception& error) {
    outcome.failure = error.what();
    if (const std::string last = place.last_words(); !last.empty()) outcome.failure += "; " + last;
  }
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

int run(const Options& options) {
  const std::vector<Case> cases = chosen(options);
  if (cases.empty()) throw BadArgument("--filter, --class", "at least one matching case (--list shows all)", "none");
  if (options.lists) {
    fmt::print("{}", listed(cases));
    return 0;
  }
  Place place(options.uri, std::chrono::milliseconds(options.timeout_ms));
  std::vector<Outcome> outcomes;
  for (const Case& tested : cases) {
    outcomes.push_back(run(tested, place));
    if (!options.quiet || !outcomes.back().failure.empty()) fmt::print("{}", line_of(outcomes.back()));
    std::fflush(stdout);
    if (options.stops && !outcomes.back().failure.empty()) break;
  }
  fmt::print("{}", summary(outcomes));
  if (!options.junit_file.empty()) {
    WholeFile file(options.junit_file);
    file.write(junit(outcomes, options.uri));
    file.commit();
  }
  return std::ranges::all_of(outcomes, [](const Outcome& each) { return each.failure.empty(); }) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Tests a board against the rules of the protocol, and reports the classes that it may claim.",
               "gicube-conformance");
  app.set_version_flag("--version", "gicube-conformance " GICUBE_VERSION);
  app.add_option("board", options.uri, "emu:, unix:PATH or tcp:HOST:PORT; no other program may use the board meanwhile")
      ->type_name("URI")
      ->capture_default_str();
  app.add_option("--class", options.classes,
                 "only cases of this class, repeatable: 0 opens and renders, 1 rays, 2 light, 3 time, 4 pictures, 5 "
                 "lasting sessions")
      ->type_name("N")
      ->check(CLI::Range(0u, kClasses - 1));
  app.add_option("--filter", options.filter, "only cases whose names contain this text")->type_name("TEXT");
  app.add_flag("--list", options.lists, "list the cases with their rules; none is run");
  app.add_option("--junit", options.junit_file, "write the results to this file, as JUnit XML")->type_name("FILE");
  app.add_option("--timeout", options.timeout_ms, "a case fails if the board is silent for longer")
      ->type_name("MS")
      ->check(CLI::Range(1u, 3'600'000u))
      ->capture_default_str();
  app.add_flag("--stop", options.stops, "stop at the first failure");
  app.add_flag("-q,--quiet", options.quiet, "print only failures and the summary");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "gicube-conformance: {}\n", usage_fault(app, error.what()));
    return 2;
  }
  try {
    const int code = run(options);
    check_standard_output();
    return code;
  } catch (const BadArgument& error) {
    fmt::print(stderr, "gicube-conformance: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-conformance: {}\n", error.what());
    return 1;
  }
}
