#include "options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <system_error>

#include "gicube/unknown_options.h"
#include "server/faults/fault_plan.h"

namespace gicube::emu {
namespace {

constexpr const char* kWindow = "BEGIN:END in core cycles, with BEGIN < END";
constexpr std::uint64_t kBytesOfMib = std::uint64_t{1} << 20;
constexpr std::uint32_t kMaxConnections = 400;  // chosen: with as many closing ones and 64 boards below 1,024 files
constexpr std::uint32_t kMaxMib = 1u << 24;     // chosen: 16 TiB

// Flags that need conversion before they become options.
struct Flags {
  std::string listen, management, config_file, restore_file;
  std::vector<std::string> overrides;
  std::string trace_file, trace_window, trace_dir, vcd_file, vcd_window, event_file, observer_file, events_of;
  std::string fault_file;
  std::string box = "auto";
  std::uint32_t resume_seconds = 10;
  std::uint32_t max_memory_mib = 0;
  std::uint32_t max_command_seconds = 0;
  std::uint32_t max_wait_seconds = static_cast<std::uint32_t>(BusOptions().max_wait.count() / 1000);
  std::uint32_t max_results_mib = static_cast<std::uint32_t>(BusOptions().max_held_bytes / kBytesOfMib);
};

void add_flags(CLI::App& app, Flags& flags, Options& options) {
  const auto add = [&app](const char* name, auto& value, const char* type, const std::string& help) {
    return app.add_option(name, value, help)->type_name(type);
  };
  add("--listen", flags.listen, "ENDPOINT",
      "where drivers open the board: unix:PATH, tcp:HOST:PORT (port 0 = any free one), or\n"
      "fd:N for a connected socket or a listening Unix socket, as from systemd;\n"
      "board i > 0 is at PATH.i or PORT+i");
  add("--boards", options.boards, "N", fmt::format("number of boards, 1 to {}", kMaxBoards));
  app.add_flag("--private", options.is_private, "with fd:N: end when that session ends");
  app.add_flag("--quiet", options.quiet, "log warnings only; the \"ready on\" lines stay");
  add("--bsdf", options.bsdf_files, "FILE",
      "a scattering routine for materials that trap, as a shared object (gicube/bsdf.h); may be given several\n"
      "times: the first is routine 8, the next 9. Its code runs in a separate process")
      ->allow_extra_args(false);
  add("--resume-seconds", flags.resume_seconds, "N",
      "time that a session waits for its client after a broken connection, unless another client requests the board; "
      "0 = none")
      ->check(CLI::Range(0u, 86'400u))
      ->capture_default_str();

  app.option_defaults()->group("Access");
  add("--tls-cert", options.certificate_file, "FILE",
      "TLS certificate, PEM: all TCP of both planes then uses TLS; required if other machines can connect");
  add("--tls-key", options.key_file, "FILE", "private key of --tls-cert, PEM");
  add("--token-file", options.token_file, "FILE",
      "tokens for clients and callers over TCP, one per line: TOKEN, read TOKEN, use TOKEN or control TOKEN\n"
      "(docs/reference/security.md); only its owner may be able to read the file. Programs of this user on this\n"
      "machine need no token");

  add("--audit-log", options.audit_log_file, "FILE",
      "append a line for each client that connects, is refused, uses force or changes something; FILE.1 holds earlier\n"
      "lines; unset: these lines go to the log");

  add("--box", flags.box, "MODE",
      "auto: after its start the process gives up all rights that a running board does not need (other files,\n"
      "programs, outgoing connections), as far as the kernel supports it; off: it keeps them")
      ->check(CLI::IsMember({"auto", "off"}))
      ->capture_default_str();

  app.option_defaults()->group("Limits");
  add("--max-memory", flags.max_memory_mib, "MIB",
      "memory for a board's volume, irradiance, sums and image; 0 = no limit")
      ->check(CLI::Range(0u, kMaxMib))
      ->capture_default_str();
  add("--max-results", flags.max_results_mib, "MIB",
      "memory that a board holds for a client: results and answers that the client has not fetched")
      ->check(CLI::Range(1u, kMaxMib))
      ->capture_default_str();
  add("--max-connections", options.bus.max_unowned, "N",
      "connections that own no board; a further one replaces the oldest that has not sent its version")
      ->check(CLI::Range(2u, kMaxConnections))
      ->capture_default_str();
  add("--max-connections-of-peer", options.bus.max_unowned_of_peer, "N",
      "the same limit for one address, or for one process of this machine")
      ->check(CLI::Range(2u, kMaxConnections))
      ->capture_default_str();
  add("--max-wait", flags.max_wait_seconds, "SECONDS", "longest time that a client may wait for a board")
      ->check(CLI::Range(1u, 86'400u))
      ->capture_default_str();

  add("--max-command-time", flags.max_command_seconds, "SECONDS",
      "processing time of a command, after which its session ends; 0 = no limit")
      ->check(CLI::Range(0u, 604'800u))
      ->capture_default_str();

  app.option_defaults()->group("Configuration");
  add("--config", flags.config_file, "FILE", "board configuration, protobuf text of gicube.v1.BoardConfig");
  add("--set", flags.overrides, "FIELD=VALUE",
      "set one field, for example asic.processors=8, after --config; may be given several times")
      ->allow_extra_args(false);
  add("--restore", flags.restore_file, "FILE",
      "each board continues from the checkpoint, with its configuration; --config and --set may change fields that do\n"
      "not shape its state (docs/guide/checkpoints.md)");
  app.add_flag("--print-config", options.print_config, "print the resolved configuration and its hash, then end");
  app.add_flag("--explain-config", options.explain_config,
               "print each field of the configuration with the source of its default, then end");
  app.add_flag("--hardware-cost", options.print_hardware_cost,
               "print the on-chip memories of the configuration, as Table 1 of the paper, then end");
  app.add_flag("--registers", options.print_registers, "print the register table and the memory map, then end");

  app.option_defaults()->group("Observation");
  add("--trace", flags.trace_file, "FILE", "write a trace for ui.perfetto.dev; board i > 0 writes FILE.i");
  add("--trace-window", flags.trace_window, "BEGIN:END", "record clocked parts in these core cycles only, without END");
  add("--trace-dir", flags.trace_dir, "FOLDER",
      "folder for traces and checkpoints that the management plane requests; unset: the working folder if that plane\n"
      "is at a Unix socket, otherwise none");
  add("--vcd", flags.vcd_file, "FILE",
      "write a waveform for GTKWave of the window; needs fidelity=cycle; board i > 0 writes FILE.i");
  add("--vcd-window", flags.vcd_window, "BEGIN:END", "core cycles of the machine's clock, without END");

  add("--events", flags.event_file, "FILE",
      "write the events of chosen rays, one JSON object per line; needs fidelity=cycle, except for life=X:Y;\n"
      "board i > 0 writes FILE.i");
  add("--observer", flags.observer_file, "FILE",
      "send the same events to a shared object (gicube/observer.h), which runs in a separate process for each board");
  add("--events-of", flags.events_of, "ITEM,...",
      "the chosen events: life=X:Y (values of a pixel's rays, at every level), pixel=X:Y, rays=BEGIN:END,\n"
      "cycles=BEGIN:END, "
      "parts=dsp+sorter+pipeline+links, counters=CYCLES");

  app.option_defaults()->group("Faults");
  add("--faults", flags.fault_file, "FILE",
      "faults between driver and board, protobuf text of gicube.v1.FaultPlan (docs/guide/faults.md)");
  add("--fault-log", options.fault_log_file, "FILE",
      "append each fault to FILE before it takes effect; board i > 0 writes FILE.i");

  app.option_defaults()->group("Management");
  add("--management", flags.management, "ENDPOINT", "serve the management plane (gRPC) at unix:PATH or tcp:HOST:PORT");
}

// Returns an empty text without a file. Reads at most one byte more than the limit, so that /dev/zero can be named.
std::string read_file(const char* flag, const std::string& path, std::vector<std::string>& errors) {
  if (path.empty()) return {};
  std::ifstream file(path, std::ios::binary);
  std::string text(kMaxTextBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.is_open() || file.bad()) {
    errors.push_back(fmt::format("{}: expected a readable file, got {}", flag, path));
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  return text;
}

void read_checkpoint(const Flags& flags, Options& options, std::vector<std::string>& errors) {
  if (flags.restore_file.empty()) return;
  try {
    options.checkpoint = std::make_shared<const Checkpoint>(Checkpoint::read(flags.restore_file));
  } catch (const std::exception& error) {
    errors.push_back(fmt::format("--restore: {}: {}", flags.restore_file, error.what()));
  }
}

// Call after read_checkpoint().
v1::BoardConfig read_config(const Flags& flags, Options& options, std::vector<std::string>& errors,
                            std::size_t& left_out) {
  ParsedConfig parsed = parse_config(read_file("--config", flags.config_file, errors));
  for (const Diagnostic& each : parsed.diagnostics) {
    errors.push_back(fmt::format("{}: {}", flags.config_file, to_string(each)));
  }
  left_out += parsed.left_out;
  for (const std::string& each : flags.overrides) {
    for (const Diagnostic& wrong : apply_override(parsed.config, each)) {
      errors.push_back("--set " + each + ": " + to_string(wrong));
    }
  }
  if (options.checkpoint) {
    v1::BoardConfig merged = options.checkpoint->header().config();
    merged.MergeFrom(parsed.config);
    for (const Diagnostic& each :
         fork_faults(options.checkpoint->header().config(), merged, options.checkpoint->header().in_command())) {
      errors.push_back("--restore: " + to_string(each));
    }
    parsed.config = merged;
  }
  for (const Diagnostic& each : check(parsed.config, parsed.lines)) {
    errors.push_back((each.line > 0 ? flags.config_file + ": " : "") + to_string(each));
  }
  options.wants_approximate = wants_approximate(parsed.config);
  return resolve(parsed.config);
}

void read_fault_plan(const Flags& flags, Options& options, std::vector<std::string>& errors, std::size_t& left_out) {
  options.fault_plan = read_file("--faults", flags.fault_file, errors);
  const ParsedFaultPlan parsed = parse_fault_plan(options.fault_plan);
  for (const Diagnostic& each : parsed.diagnostics) {
    errors.push_back(fmt::format("{}: {}", flags.fault_file, to_string(each)));
  }
  left_out += parsed.left_out;
}

std::optional<Endpoint> read_endpoint(const char* flag, const std::string& text, std::vector<std::string>& errors) {
  try {
    return parse_endpoint(text);
  } catch (const std::invalid_argument& error) {
    errors.push_back(fmt::format("{}: {}", flag, error.what()));
    return std::nullopt;
  }
}

// The error for a flag without the other one that it needs.
std::string alone(std::string_view flag, std::string_view other) {
  return fmt::format("{}: expected {} beside it, got none", flag, other);
}

void check_tls(const Options& options, std::vector<std::string>& errors) {
  if (options.certificate_file.empty() == options.key_file.empty()) return;
  const bool has_key = options.certificate_file.empty();
  errors.push_back(has_key ? alone("--tls-key", "--tls-cert") : alone("--tls-cert", "--tls-key"));
}

void need_cycles(const char* flag, const char* what, const Options& options, std::vector<std::string>& errors) {
  if (options.config.fidelity() == v1::cycle) return;
  errors.push_back(fmt::format("{}: expected fidelity=cycle, got {}: only that level has {}", flag,
                               v1::FidelityLevel_Name(options.config.fidelity()), what));
}

void read_listen(const Flags& flags, Options& options, std::vector<std::string>& errors) {
  if (options.boards < 1 || options.boards > kMaxBoards) {
    errors.push_back(fmt::format("--boards: expected 1 to {}, got {}", kMaxBoards, options.boards));
  }
  if (flags.listen.empty()) {
    if (!options.prints_only()) errors.push_back("--listen: expected unix:PATH, tcp:HOST:PORT or fd:N, got nothing");
    return;
  }
  const std::optional<Endpoint> endpoint = read_endpoint("--listen", flags.listen, errors);
  if (!endpoint) return;
  options.listen = *endpoint;
  if (!is_local(*endpoint) && (options.certificate_file.empty() || options.token_file.empty())) {
    errors.push_back(fmt::format(
        "--listen: expected a loopback address or a unix socket, or TLS and a token by --tls-cert, --tls-key, "
        "--token-file, got {}",
        flags.listen));
  }
  if (options.is_private && endpoint->kind != EndpointKind::kFd) {
    errors.push_back(fmt::format("--private: expected --listen fd:N, got {}", flags.listen));
  }
  try {
    for_board(*endpoint, options.boards >= 1 && options.boards <= kMaxBoards ? options.boards - 1 : 0);
  } catch (const std::invalid_argument& error) {
    errors.push_back(fmt::format("--boards: {}", error.what()));
  }
}

// Callers at a user's socket are that user, so they cannot write files here that they could not write anyway.
std::string read_trace_folder(const Flags& flags, const Endpoint& management, std::vector<std::string>& errors) {
  const bool is_given = !flags.trace_dir.empty();
  if (!is_given && management.kind != EndpointKind::kUnix) return {};
  std::error_code error;
  const auto folder = std::filesystem::canonical(is_given ? flags.trace_dir : ".", error);
  if (!error && std::filesystem::is_directory(folder, error)) return folder.string();
  if (is_given) errors.push_back(fmt::format("--trace-dir: expected a folder, got {}", flags.trace_dir));
  return {};
}

void read_management(const Flags& flags, Options& options, std::vector<std::string>& errors) {
  if (flags.management.empty()) {
    if (!flags.trace_dir.empty()) errors.push_back("--management: expected an endpoint beside --trace-dir, got none");
    return;
  }
  const std::optional<Endpoint> endpoint = read_endpoint("--management", flags.management, errors);
  if (!endpoint) return;
  options.management.emplace();
  options.management->endpoint = *endpoint;
  options.management->certificate_file = options.certificate_file;
  options.management->key_file = options.key_file;
  options.management->token_file = options.token_file;
  options.management->trace_folder = read_trace_folder(flags, *endpoint, errors);
  for (const Diagnostic& each : check(*options.management)) errors.push_back(to_string(each));
}

// Returns an empty window, and reports it, if the text is not one.
CycleWindow read_window(const char* flag, const std::string& text, std::vector<std::string>& errors) {
  const auto window = parse_window(text);
  if (!window && !text.empty()) errors.push_back(fmt::format("{}: expected {}, got {}", flag, kWindow, text));
  return window.value_or(CycleWindow{});
}

void read_events(const Flags& flags, Options& options, std::vector<std::string>& errors) {
  const bool is_asked = !flags.event_file.empty() || !flags.observer_file.empty();
  const char* const flag = flags.event_file.empty() ? "--observer" : "--events";
  if (is_asked == flags.events_of.empty()) {
    errors.push_back(is_asked ? alone(flag, "--events-of ITEM,...")
                              : alone("--events-of", "--events FILE or --observer FILE"));
  }
  if (!is_asked || flags.events_of.empty()) return;
  options.observation.event_file = flags.event_file;
  options.observation.observer_file = flags.observer_file;
  options.observation.is_boxed = options.is_boxed;
  try {
    options.observation.events = parse_selection(flags.events_of);
  } catch (const std::invalid_argument& error) {
    errors.push_back(fmt::format("--events-of: {}", error.what()));
  }
  if (!options.observation.events.life) need_cycles(flag, "parts with events", options, errors);
  if (!flags.event_file.empty() && (flags.event_file == flags.trace_file || flags.event_file == flags.vcd_file)) {
    errors.push_back(fmt::format("--events: expected another file than --trace and --vcd, got {}", flags.event_file));
  }
}

// Call after read_config().
void read_observation(const Flags& flags, Options& options, std::vector<std::string>& errors) {
  options.observation = {.trace_file = flags.trace_file, .vcd_file = flags.vcd_file};
  options.observation.trace_window = read_window("--trace-window", flags.trace_window, errors);
  options.observation.vcd_window = read_window("--vcd-window", flags.vcd_window, errors);
  if (!flags.trace_window.empty() && flags.trace_file.empty())
    errors.push_back(alone("--trace-window", "--trace FILE"));
  read_events(flags, options, errors);
  if (flags.vcd_file.empty()) {
    if (!flags.vcd_window.empty()) errors.push_back(alone("--vcd-window", "--vcd FILE"));
    return;
  }
  if (flags.vcd_window.empty()) errors.push_back(alone("--vcd", fmt::format("--vcd-window {}", kWindow)));
  need_cycles("--vcd", "clocked signals", options, errors);
  if (flags.vcd_file == flags.trace_file) {
    errors.push_back(fmt::format("--vcd: expected another file than --trace, got {}", flags.vcd_file));
  }
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv) {
  CommandLine result;
  Flags flags;
  CLI::App app("An emulated GI-Cube board as a process of its own: drivers open it over a socket, gRPC manages it.",
               "gicube-board");
  app.set_version_flag("--version", "gicube-board " GICUBE_VERSION);
  add_flags(app, flags, result.options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    result.text = app.help();
    return result;
  } catch (const CLI::CallForVersion& version) {
    result.text = std::string(version.what()) + "\n";
    return result;
  } catch (const CLI::ParseError& error) {
    result.errors.push_back(usage_fault(app, error.what()));
    return result;
  }
  if (flags.max_memory_mib > 0) result.options.max_memory_bytes = flags.max_memory_mib * kBytesOfMib;
  BusOptions& bus = result.options.bus;
  bus.resume_limit = std::chrono::seconds(flags.resume_seconds);
  bus.max_command_time = std::chrono::seconds(flags.max_command_seconds);
  bus.max_wait = std::chrono::seconds(flags.max_wait_seconds);
  bus.max_held_bytes = flags.max_results_mib * kBytesOfMib;
  result.options.is_boxed = flags.box == "auto";
  check_tls(result.options, result.errors);
  read_listen(flags, result.options, result.errors);
  read_management(flags, result.options, result.errors);
  read_checkpoint(flags, result.options, result.errors);
  result.options.config = read_config(flags, result.options, result.errors, result.errors_left_out);
  read_observation(flags, result.options, result.errors);
  read_fault_plan(flags, result.options, result.errors, result.errors_left_out);
  return result;
}

}  // namespace gicube::emu
