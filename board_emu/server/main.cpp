// gicube-board: one process, one or more emulated boards.
//
// Exit codes: 0 = ended by a signal or with its private session; 1 = socket or file error; 2 = error in options or
// configuration.
#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/prctl.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <ranges>
#include <stdexcept>
#include <utility>
#include <vector>

#include "audit.h"
#include "box/box.h"
#include "config/hardware_cost.h"
#include "end_on_signals.h"
#include "firmware/routines/routine_table.h"
#include "gicube/access.h"
#include "gicube/whole_file.h"
#include "gicube/wire/register_markdown.h"
#include "options.h"
#include "server/bus/board_slot.h"
#include "server/bus/bus_server.h"
#include "server/management/management.h"
#include "server/management/registration.h"
#include "token_files.h"
#include "words/scope_exit.h"

namespace gicube::emu {
namespace {

// Scripts wait for these lines, so their format is fixed.
void say_ready(const std::string& what, const Endpoint& endpoint) {
  std::fputs(fmt::format("gicube-board: {} ready on {}\n", what, to_string(endpoint)).c_str(), stdout);
  std::fflush(stdout);
}

// Throws PlugInFault.
void load_routines(const Options& options, RoutineTable& routines) {
  // Routines run as this user. This setting prevents their processes from reading this process's memory.
  if (!options.bsdf_files.empty()) ::prctl(PR_SET_DUMPABLE, 0);
  for (const std::string& file : options.bsdf_files) routines.add(PlugIn::load(file, options.is_boxed));
  for (const RoutineInfo& routine : routines.list()) {
    if (routine.file.empty()) continue;
    spdlog::info("scattering routine {}: \"{}\" of {}, {} DSP cycles, at most {}", routine.number, routine.name,
                 routine.file, routine.cycles, routine.cycle_budget);
  }
}

// A closed terminal ends the process, unless it was started with nohup.
std::vector<int> signals_to_end_on() {
  std::vector<int> signals{SIGINT, SIGTERM};
  struct sigaction hang_up {};
  if (::sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN) signals.push_back(SIGHUP);
  return signals;
}

std::string folder_of(const std::string& file) {
  const std::string folder = std::filesystem::path(file).parent_path().string();
  return folder.empty() ? "." : folder;
}

// The files that the process still opens, creates and removes. `made`: files that it removes at its end. The files of
// --trace, --vcd and --fault-log are already open.
Box box_of(const Options& options, const std::vector<std::string>& tokens, const std::vector<std::string>& made) {
  using enum Box::Access;
  Box box;
  // Before removing a token file, the process checks that it is still its own.
  for (const std::string& file : tokens) box.paths.push_back({file, kRead});
  for (const std::string& file : made) box.paths.push_back({folder_of(file), kRemove});
  if (!options.audit_log_file.empty()) box.paths.push_back({folder_of(options.audit_log_file), kWrite});
  if (options.management && !options.management->trace_folder.empty()) {
    box.paths.push_back({options.management->trace_folder, kWrite});
  }
  return box;
}

// Never fails: without kernel support, the boards run without the sandbox or with a part of it.
void enter(const Box& box) {
  const Boxed boxed = enter_box(box);
  const bool is_fault = boxed.files == Boxed::Part::kFailed || boxed.calls == Boxed::Part::kFailed;
  spdlog::log(is_fault ? spdlog::level::warn : spdlog::level::info, boxed.text);
}

void serve(const Options& options, const RoutineTable& routines) {
  std::signal(SIGPIPE, SIG_IGN);  // a closed log pipe must not end the process
  EndOnSignals ending(signals_to_end_on());
  Audit audit({.file = options.audit_log_file});
  std::vector<std::unique_ptr<BoardSlot>> slots;
  std::vector<BoardSlot*> boards;
  for (std::uint32_t i = 0; i < options.boards; ++i) {
    slots.push_back(std::make_unique<BoardSlot>(i, options.config, for_board(options.observation, i), &routines,
                                                options.max_memory_bytes, options.checkpoint));
    FaultPoint& faults = slots.back()->faults();
    if (!options.fault_plan.empty())
      faults.set_plan(options.fault_plan);  // already checked; without one, a checkpoint's plan continues
    const std::string suffix = i == 0 ? "" : fmt::format(".{}", i);
    if (!options.fault_log_file.empty()) faults.append_log_to(options.fault_log_file + suffix);
    boards.push_back(slots.back().get());
  }
  BusOptions bus = options.bus;
  bus.audit = &audit;
  if (!options.certificate_file.empty()) bus.tls = make_tls(options.certificate_file, options.key_file);
  const AccessToken own{Right::kControl, new_token()};
  if (!options.token_file.empty()) bus.tokens = read_tokens(options.token_file);
  bus.tokens.push_back(own);
  BusServer server(bus);
  ending.set_stop([&server] { server.stop(); });
  const ScopeExit server_goes{[&ending] { ending.set_stop([] {}); }};
  std::vector<Endpoint> endpoints;
  std::vector<std::string> made;  // files that are removed at the end of the process
  const auto add_made = [&](const std::string& path) {
    made.push_back(path);
    ending.add_file(path);
  };
  for (BoardSlot* slot : boards) {
    const Endpoint endpoint = for_board(options.listen, slot->index());
    if (endpoint.kind == EndpointKind::kFd && (options.is_private || !is_listening(endpoint.fd))) {
      server.adopt(*slot, endpoint.fd, options.is_private);
    } else {
      endpoints.push_back(server.listen(*slot, endpoint));
      if (endpoint.kind == EndpointKind::kUnix) made.push_back(endpoint.path);
    }
  }
  // Declared after the server, so that it is destroyed before the sockets and the boards.
  std::unique_ptr<Management> management;
  if (options.management) {
    ManagementOptions at = *options.management;
    at.tokens = {own};
    at.audit = &audit;
    management = std::make_unique<Management>(at, boards);
    if (options.management->endpoint.kind == EndpointKind::kUnix) add_made(options.management->endpoint.path);
  }
  std::optional<TokenFiles> token_files;
  try {
    std::vector<Endpoint> all = endpoints;
    if (management) all.push_back(management->endpoint());
    token_files.emplace(all, own.token);
    for (const std::string& path : token_files->paths()) add_made(path);
  } catch (const std::runtime_error& error) {  // tokens of --token-file still work
    if (options.token_file.empty()) throw;
    spdlog::warn("programs of this user need a token: {}", error.what());
  }
  std::optional<Registration> registration;
  try {
    registration.emplace(management ? to_string(management->endpoint()) : "", boards, &audit,
                         [&server] { return server.quotas(); });
    add_made(registration->path());
  } catch (const std::runtime_error& error) {  // the boards are usable without it
    spdlog::warn("gicube-smi cannot find this process: {}", error.what());
  }
  if (options.is_boxed) enter(box_of(options, token_files ? token_files->paths() : std::vector<std::string>(), made));
  for (std::size_t i = 0; i < endpoints.size(); ++i) say_ready(fmt::format("board {}", i), endpoints[i]);
  if (management) say_ready("management", management->endpoint());
  spdlog::info("configuration {}", config_hash_text(options.config));
  server.run();
  spdlog::info("shutting down");
}

int run(int argc, const char* const* argv) {
  const CommandLine line = parse_command_line(argc, argv);
  constexpr std::size_t kMaxErrors = 50;  // chosen: two screens; a file of another format has an error in every line
  for (const std::string& error : line.errors | std::views::take(kMaxErrors))
    fmt::print(stderr, "gicube-board: {}\n", error);
  const std::size_t more = line.errors.size() - std::min(line.errors.size(), kMaxErrors) + line.errors_left_out;
  if (more > 0) fmt::print(stderr, "gicube-board: and {} more\n", more);
  if (!line.errors.empty()) return 2;
  if (line.text) {
    fmt::print("{}", *line.text);
    check_standard_output();
    return 0;
  }
  if (line.options.print_config) {
    fmt::print("{}# config_hash: {}\n", config_text(line.options.config), config_hash_text(line.options.config));
  }
  if (line.options.explain_config) fmt::print("{}", explained(line.options.config));
  if (line.options.print_registers) fmt::print("{}\n{}", wire::register_markdown(), wire::memory_markdown());
  if (line.options.print_hardware_cost) fmt::print("{}", to_string(hardware_cost(line.options.config)));
  if (line.options.prints_only()) {
    check_standard_output();
    return 0;
  }
  spdlog::set_default_logger(spdlog::stderr_logger_mt("gicube-board"));
  spdlog::set_level(line.options.quiet ? spdlog::level::warn : spdlog::level::info);
  if (line.options.wants_approximate) spdlog::warn(kApproximateIsCycle);
  RoutineTable routines;  // not unloaded while a board exists
  try {
    load_routines(line.options, routines);
  } catch (const PlugInFault& fault) {
    fmt::print(stderr, "gicube-board: --bsdf: {}\n", fault.what());
    return 2;
  }
  serve(line.options, routines);
  return 0;
}

}  // namespace
}  // namespace gicube::emu

int main(int argc, char** argv) {
  ::umask(S_IRWXG | S_IRWXO);  // socket files are accessible only to their owner
  // Chosen: results of commands have a few megabytes and recur. Returning their memory to the system each time would
  // cost a tenth of the time of host rays for new pages. Up to 128 MiB are kept.
  ::mallopt(M_MMAP_THRESHOLD, 32 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 128 << 20);
  try {
    return gicube::emu::run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "gicube-board: {}\n", error.what());
    return 1;
  }
}
