#include "options.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <exception>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

#include "server/faults/fault_plan.h"

namespace gicube::emu {
namespace {

// The flags as they were typed.
struct Flags {
  std::string listen, management, config_file;
  std::vector<std::string> overrides, bsdf_files;
  std::string certificate_file, key_file, token_file;
  std::string trace_file, vcd_file, vcd_window;
  std::string fault_file, fault_log_file;
  std::uint32_t boards = 1, resume_seconds = 10;
  bool allow_remote_bus = false, is_private = false, quiet = false, print_config = false, print_registers = false,
       print_hardware_cost = false;
};

void add_flags(CLI::App& app, Flags& flags) {
  app.add_option("--listen", flags.listen,
                 "where drivers open the board: unix:PATH, tcp:HOST:PORT (port 0 = any free one), or\n"
                 "fd:N for a connected socket; board i > 0 is at PATH.i or PORT+i")
      ->type_name("ENDPOINT");
  app.add_option("--boards", flags.boards, fmt::format("how many boards, 1 to {}", kMaxBoards))->type_name("N");
  app.add_flag("--private", flags.is_private, "with fd:N: end with that session");
  app.add_flag("--allow-remote-bus", flags.allow_remote_bus,
               "let --listen be an address that other machines can reach; the bus has no password");
  app.add_flag("--quiet", flags.quiet, "log warnings only");

  app.add_option("--bsdf", flags.bsdf_files,
                 "a scattering routine for materials that trap, a shared object (gicube/bsdf.h); may come several\n"
                 "times: the first is routine 8, the next 9. Its code runs in this process, with all its rights")
      ->type_name("FILE")
      ->allow_extra_args(false);

  app.add_option("--config", flags.config_file, "board configuration, protobuf text of gicube.v1.BoardConfig")
      ->type_name("FILE")
      ->group("Configuration");
  app.add_option("--set", flags.overrides, "set one field after that, as asic.processors=8; may come several times")
      ->type_name("FIELD=VALUE")
      ->allow_extra_args(false)
      ->group("Configuration");
  app.add_flag("--print-config", flags.print_config, "print the resolved configuration and its hash, then end")
      ->group("Configuration");
  app.add_flag("--hardware-cost", flags.print_hardware_cost,
               "print what the configuration's ASIC holds in memories, Table 1 of the paper, then end")
      ->group("Configuration");
  app.add_flag("--registers", flags.print_registers, "print the register table and the memory map, then end")
      ->group("Configuration");

  app.add_option("--trace", flags.trace_file, "write a trace for ui.perfetto.dev; board i > 0 writes FILE.i")
      ->type_name("FILE")
      ->group("Observation");
  app.add_option("--vcd", flags.vcd_file,
                 "write a waveform for GTKWave of the window; needs fidelity=cycle; board i > 0 writes FILE.i")
      ->type_name("FILE")
      ->group("Observation");
  app.add_option("--vcd-window", flags.vcd_window, "core cycles of the machine's clock, END left out")
      ->type_name("BEGIN:END")
      ->group("Observation");

  app.add_option("--resume-seconds", flags.resume_seconds,
                 "how long a session whose connection broke waits for its client, unless another one comes; 0 = not")
      ->type_name("N")
      ->check(CLI::Range(0u, 86'400u))
      ->capture_default_str();

  app.add_option(
         "--faults", flags.fault_file,
         "what goes wrong between driver and board, protobuf text of gicube.v1.FaultPlan (docs/guide/faults.md)")
      ->type_name("FILE")
      ->group("Faults");
  app.add_option("--fault-log", flags.fault_log_file,
                 "append each fault to FILE before it takes effect; board i > 0 writes FILE.i")
      ->type_name("FILE")
      ->group("Faults");

  app.add_option("--management", flags.management, "serve the management plane (gRPC) at unix:PATH or tcp:HOST:PORT")
      ->type_name("ENDPOINT")
      ->group("Management");
  app.add_option("--management-cert", flags.certificate_file, "TLS certificate, PEM; needed beyond this machine")
      ->type_name("FILE")
      ->group("Management");
  app.add_option("--management-key", flags.key_file, "its private key, PEM")->type_name("FILE")->group("Management");
  app.add_option(
         "--management-token-file", flags.token_file,
         "the token that callers must send as \"authorization: Bearer TOKEN\"; only its owner may read the file")
      ->type_name("FILE")
      ->group("Management");
}

v1::BoardConfig read_config(const Flags& flags, std::vector<std::string>& faults) {
  ParsedConfig parsed;
  if (!flags.config_file.empty()) {
    std::ifstream file(flags.config_file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (!file) {
      faults.push_back(fmt::format("--config: expected a readable file, got {}", flags.config_file));
    } else {
      parsed = parse_config(text);
    }
  }
  for (const Fault& fault : parsed.faults) faults.push_back(fmt::format("{}: {}", flags.config_file, to_string(fault)));
  for (const std::string& each : flags.overrides) {
    for (const Fault& fault : apply_override(parsed.config, each))
      faults.push_back("--set " + each + ": " + to_string(fault));
  }
  for (const Fault& fault : check(parsed.config, parsed.lines)) {
    const std::string file = fault.line > 0 ? flags.config_file + ": " : "";
    faults.push_back(file + to_string(fault));
  }
  return resolve(parsed.config);
}

void read_fault_plan(const Flags& flags, Options& options, std::vector<std::string>& faults) {
  options.fault_log_file = flags.fault_log_file;
  if (flags.fault_file.empty()) return;
  std::ifstream file(flags.fault_file, std::ios::binary);
  options.fault_plan = {std::istreambuf_iterator<char>(file), {}};
  if (!file) {
    faults.push_back(fmt::format("--faults: expected a readable file, got {}", flags.fault_file));
    return;
  }
  for (const Fault& fault : parse_fault_plan(options.fault_plan).faults) {
    faults.push_back(fmt::format("{}: {}", flags.fault_file, to_string(fault)));
  }
}

std::optional<Endpoint> read_endpoint(const char* flag, const std::string& text, std::vector<std::string>& faults) {
  try {
    return parse_endpoint(text);
  } catch (const std::invalid_argument& error) {
    faults.push_back(fmt::format("{}: {}", flag, error.what()));
    return std::nullopt;
  }
}

void read_listen(const Flags& flags, Options& options, std::vector<std::string>& faults) {
  if (flags.boards < 1 || flags.boards > kMaxBoards) {
    faults.push_back(fmt::format("--boards: expected 1 to {}, got {}", kMaxBoards, flags.boards));
  }
  if (flags.listen.empty()) {
    const bool prints_only = flags.print_config || flags.print_registers || flags.print_hardware_cost;
    if (!prints_only) faults.push_back("--listen: expected unix:PATH, tcp:HOST:PORT or fd:N, got nothing");
    return;
  }
  const std::optional<Endpoint> endpoint = read_endpoint("--listen", flags.listen, faults);
  if (!endpoint) return;
  options.listen = *endpoint;
  if (!is_local(*endpoint) && !flags.allow_remote_bus) {
    faults.push_back(fmt::format("--listen: expected a loopback address or --allow-remote-bus, got {}", flags.listen));
  }
  if (flags.is_private && endpoint->kind != EndpointKind::kFd) {
    faults.push_back(fmt::format("--private: expected --listen fd:N, got {}", flags.listen));
  }
  try {
    for_board(*endpoint, flags.boards >= 1 && flags.boards <= kMaxBoards ? flags.boards - 1 : 0);
  } catch (const std::invalid_argument& error) {
    faults.push_back(fmt::format("--boards: {}", error.what()));
  }
}

void read_management(const Flags& flags, Options& options, std::vector<std::string>& faults) {
  const bool has_files = !(flags.certificate_file + flags.key_file + flags.token_file).empty();
  if (flags.management.empty()) {
    if (has_files) faults.push_back("--management: expected an endpoint for the certificate, key or token, got none");
    return;
  }
  const std::optional<Endpoint> endpoint = read_endpoint("--management", flags.management, faults);
  if (!endpoint) return;
  options.management = ManagementOptions{*endpoint, flags.certificate_file, flags.key_file, flags.token_file};
  for (const Fault& fault : check(*options.management)) faults.push_back(to_string(fault));
}

std::optional<CycleWindow> parse_window(std::string_view text) {
  CycleWindow window;
  const char* const end = text.data() + text.size();
  const auto begin_end = std::from_chars(text.data(), end, window.begin);
  if (begin_end.ec != std::errc() || begin_end.ptr == end || *begin_end.ptr != ':') return std::nullopt;
  const auto end_end = std::from_chars(begin_end.ptr + 1, end, window.end);
  if (end_end.ec != std::errc() || end_end.ptr != end || window.end <= window.begin) return std::nullopt;
  return window;
}

// After read_config().
void read_observation(const Flags& flags, Options& options, std::vector<std::string>& faults) {
  options.observation = {flags.trace_file, flags.vcd_file, {}};
  if (flags.vcd_file.empty()) {
    if (!flags.vcd_window.empty()) faults.push_back("--vcd-window: expected --vcd FILE beside it, got none");
    return;
  }
  const char* const expected = "BEGIN:END in core cycles, with BEGIN < END";
  if (flags.vcd_window.empty()) {
    faults.push_back(fmt::format("--vcd: expected --vcd-window {} beside it, got none", expected));
  } else if (const auto window = parse_window(flags.vcd_window)) {
    options.observation.vcd_window = *window;
  } else {
    faults.push_back(fmt::format("--vcd-window: expected {}, got {}", expected, flags.vcd_window));
  }
  if (options.config.fidelity() != v1::cycle) {
    faults.push_back(fmt::format("--vcd: expected fidelity=cycle, got {}: only that level has clocked signals",
                                 v1::FidelityLevel_Name(options.config.fidelity())));
  }
  if (flags.vcd_file == flags.trace_file) {
    faults.push_back(fmt::format("--vcd: expected another file than --trace, got {}", flags.vcd_file));
  }
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv) {
  CommandLine result;
  Flags flags;
  CLI::App app("An emulated GI-Cube board as a process of its own: drivers open it over a socket, gRPC manages it.",
               "gicube-board");
  app.set_version_flag("--version", "gicube-board " GICUBE_VERSION);
  add_flags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    result.text = app.help();
    return result;
  } catch (const CLI::CallForVersion& version) {
    result.text = std::string(version.what()) + "\n";
    return result;
  } catch (const CLI::ParseError& error) {
    result.faults.push_back(error.what());
    return result;
  }
  result.options.boards = flags.boards;
  result.options.is_private = flags.is_private;
  result.options.resume_limit = std::chrono::seconds(flags.resume_seconds);
  result.options.quiet = flags.quiet;
  result.options.bsdf_files = flags.bsdf_files;
  result.options.print_config = flags.print_config;
  result.options.print_registers = flags.print_registers;
  result.options.print_hardware_cost = flags.print_hardware_cost;
  read_listen(flags, result.options, result.faults);
  read_management(flags, result.options, result.faults);
  result.options.config = read_config(flags, result.faults);
  read_observation(flags, result.options, result.faults);
  read_fault_plan(flags, result.options, result.faults);
  return result;
}

}  // namespace gicube::emu
