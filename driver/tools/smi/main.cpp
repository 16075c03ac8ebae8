// gicube-smi: lists boards, shows their activity, tests them, and finds out why one can't be opened.
//
// Exit codes: 0 success, 1 a negative answer or a failed call, 2 wrong usage.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <exception>
#include <stdexcept>
#include <string>
#include <vector>

#include "arguments.h"
#include "gicube/unknown_options.h"
#include "gicube/whole_file.h"
#include "options.h"

namespace gicube::smi {
namespace {

using Command = int (*)(const Options&);

constexpr std::chrono::milliseconds kMinInterval{10},
    kMaxInterval{60'000};  // the limits of WatchCounters (management.proto)

void add_management(CLI::App& app, Options& options, const char* what) {
  app.add_option("-m,--management", options.management, what)->type_name("ENDPOINT")->envname("GICUBE_MANAGEMENT");
  app.add_option("--ca", options.ca_file, "TLS: the certificate that signed the board's, PEM")->type_name("FILE");
  app.add_option("--token-file", options.token_file,
                 "the token that the board asks for; a board of this user on this machine needs none")
      ->type_name("FILE");
}

constexpr const char* kManagement =
    "management plane of the board process: unix:PATH or tcp:HOST:PORT; default: that of the only local one";

void add_json(CLI::App& app, Options& options) {
  app.add_flag("--json", options.json, "for programs: JSON instead of text");
}

CLI::App* add_command(CLI::App& app, Options& options, Command run, const char* name, const char* what) {
  CLI::App* sub = app.add_subcommand(name, what);
  sub->callback([&options, run] { options.run = run; });
  add_json(*sub, options);
  return sub;
}

// A command about one board of a process.
CLI::App* add_board_command(CLI::App& app, Options& options, Command run, const char* name, const char* what) {
  CLI::App* sub = add_command(app, options, run, name, what);
  add_management(*sub, options, kManagement);
  sub->add_option("-b,--board", options.board, "the board's number in its process")->type_name("N");
  return sub;
}

std::uint32_t interval_of(const std::string& text) try {
  const std::chrono::milliseconds interval = time_with_unit(text);
  if (interval < kMinInterval || interval > kMaxInterval) {
    throw std::invalid_argument(fmt::format("expected 10ms to 60s, got {}", text));
  }
  return static_cast<std::uint32_t>(interval.count());
} catch (const std::invalid_argument& error) {
  throw CLI::ValidationError("--interval", error.what());
}

void add_top(CLI::App& app, Options& options) {
  CLI::App* top =
      add_board_command(app, options, smi::top, "top", "the activity of a board, once per second; ends with Ctrl-C");
  top->add_option_function<std::string>(
         "-i,--interval", [&options](const std::string& text) { options.interval_ms = interval_of(text); },
         "between two samples, 10ms to 60s, for instance 500ms")
      ->type_name("TIME")
      ->default_str("1s");
  top->add_option("-n,--count", options.count, "end after this many samples")
      ->type_name("N")
      ->check(CLI::Range(1, 1 << 30));
  top->add_flag_callback(
      "--once", [&options] { options.count = 1; }, "one sample, like -n 1: everything since the board was reset");
  top->add_flag("-a,--all", options.all_counters, "every counter, also unchanged ones");
}

void add_faults(CLI::App& app, Options& options) {
  CLI::App* faults = app.add_subcommand("faults", "the fault plan of a board: faults that are injected");
  faults->require_subcommand(1);
  add_board_command(*faults, options, show_faults, "show", "the plan in force, and the faults that it has injected");
  add_board_command(*faults, options, set_faults, "set", "replace the plan")
      ->add_option("plan", options.plan_file, "protobuf text of gicube.v1.FaultPlan; - reads standard input")
      ->type_name("FILE")
      ->required();
  add_board_command(*faults, options, clear_faults, "clear", "remove the plan");
  add_board_command(*faults, options, log_faults, "log", "the injected faults, as a plan that repeats them")
      ->add_flag("--clear", options.clear_log, "empty the log");
}

void add_trace(CLI::App& app, Options& options) {
  CLI::App* trace = app.add_subcommand("trace", "a trace of a board, for ui.perfetto.dev");
  trace->require_subcommand(1);
  add_board_command(*trace, options, show_trace, "show", "where the board writes its trace");
  add_board_command(*trace, options, start_trace, "start", "traces all later sessions; the board must be free")
      ->add_option("file", options.trace_file,
                   "a new file in the folder that gicube-board has for traces (--trace-dir)")
      ->type_name("FILE")
      ->required();
  add_board_command(*trace, options, stop_trace, "stop", "completes the file; the board must be free");
}

void add_checkpoint(CLI::App& app, Options& options) {
  add_board_command(app, options, checkpoint, "checkpoint",
                    "writes a board's whole state to a file, for gicube-board --restore; its session continues")
      ->add_option("file", options.checkpoint_file,
                   "a new file in the folder that gicube-board has for traces (--trace-dir)")
      ->type_name("FILE")
      ->required();
}

void add_export(CLI::App& app, Options& options) {
  CLI::App* sub = app.add_subcommand("export", "the counters of all local boards to Prometheus; ends with Ctrl-C");
  sub->callback([&options] { options.run = export_metrics; });
  sub->add_option("--listen", options.listen,
                  "serve http://ADDRESS:PORT/metrics on a loopback address; port 0: any free one")
      ->type_name("ADDRESS:PORT")
      ->required();
}

void add_uri(CLI::App& app, Options& options, const char* what) {
  app.add_option("uri", options.uri, what)->type_name("URI")->capture_default_str();
}

// Throws UsageError.
int run(int argc, const char* const* argv) {
  Options options;
  CLI::App app(
      "Lists GI-Cube boards, watches and tests them, and finds out why one can't be opened.\n"
      "Without a command: a summary of all boards of this user on this machine. Commands that look at a running board\n"
      "ask the management plane that --management or the environment variable GICUBE_MANAGEMENT names, or else that "
      "of\n"
      "the only board process of this user on this machine. Options may stand before or after the command.",
      "gicube-smi");
  app.set_version_flag("--version", "gicube-smi " GICUBE_VERSION);
  app.require_subcommand(0, 1);
  add_json(app, options);

  add_management(*add_command(app, options, list, "list", "the boards of a process; without one, PCI functions"),
                 options, kManagement);
  add_board_command(app, options, info, "info", "a board's configuration and routines");
  add_top(app, options);
  add_uri(*add_command(app, options, validate, "validate",
                       "opens a board and tests it; its contents are lost. Exit code 1 if a test fails"),
          options, "the board, as Board::open() takes it");
  add_board_command(app, options, reset, "reset",
                    "the power button: ends the session that owns the board, clears all state");
  add_faults(app, options);
  add_trace(app, options);
  add_board_command(app, options, smi::debug, "debug",
                    "pauses a board at conditions and inspects it; the board continues when this ends")
      ->add_option("script", options.script_file, "commands to run; - reads standard input (help lists them)")
      ->type_name("FILE")
      ->capture_default_str();
  add_checkpoint(app, options);
  add_export(app, options);
  add_command(app, options, show, "show",
              "where a PNG, EXR, NRRD, NIfTI or JSON file came from: program, command, board, scene")
      ->add_option("file", options.shown_file, "written by a program of this SDK")
      ->type_name("FILE")
      ->required();
  CLI::App* doctor = add_command(app, options, smi::doctor, "doctor",
                                 "finds out why a board can't be opened. Exit code 1 if it can't");
  add_uri(*doctor, options, "the board that an application would open");
  add_management(*doctor, options, "also looks at this management plane: unix:PATH or tcp:HOST:PORT");

  try {
    std::vector<std::string> words = command_first(app, {argv + 1, argv + argc});
    std::ranges::reverse(words);  // as CLI11 takes them
    app.parse(std::move(words));
  } catch (const CLI::Success& help_or_version) {
    return app.exit(help_or_version);
  } catch (const CLI::ParseError& error) {
    throw UsageError(usage_fault(app, error.what()) + " (--help says more)");
  }
  return options.run(options);
}

}  // namespace
}  // namespace gicube::smi

int main(int argc, char** argv) {
  using namespace gicube::smi;
  try {
    const int code = run(argc, argv);
    gicube::check_standard_output();
    return code;
  } catch (const UsageError& error) {
    fmt::print(stderr, "gicube-smi: {}\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-smi: {}\n", error.what());
    return 1;
  }
}
