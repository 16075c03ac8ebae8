// The command line of gicube-board.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "board/checkpoint.h"
#include "config/config.h"
#include "observe/observation.h"
#include "server/bus/endpoint.h"
#include "server/bus/session.h"
#include "server/management/management.h"

namespace gicube::emu {

inline constexpr std::uint32_t kMaxBoards = 64;  // chosen: each has its own thread

struct Options {
  Endpoint listen;
  std::optional<ManagementOptions> management;
  v1::BoardConfig config;                        // resolved and checked
  bool wants_approximate = false;                // instead of config's cycle
  std::shared_ptr<const Checkpoint> checkpoint;  // initial state of the boards; null: none
  std::uint32_t boards = 1;
  ObservationOptions observation;
  std::string fault_plan;                             // plan text; empty: no faults
  std::string fault_log_file;                         // empty: none
  std::vector<std::string> bsdf_files;                // scattering routines, in the order of their numbers
  BusOptions bus;                                     // without tokens, TLS and audit log
  std::uint64_t max_memory_bytes = kUnlimitedMemory;  // per board
  std::string audit_log_file;                         // empty: lines go to the process's log
  std::string certificate_file, key_file;             // for TLS; empty: plain TCP
  std::string token_file;                             // for clients over TCP; empty: only this process's own token
  bool is_boxed = true;                               // if the kernel supports it
  bool is_private = false;
  bool quiet = false;
  bool print_config = false;
  bool explain_config = false;
  bool print_registers = false;
  bool print_hardware_cost = false;

  // Whether the program only prints and runs no board.
  bool prints_only() const { return print_config || explain_config || print_registers || print_hardware_cost; }
};

// The parsed command line, or text to print instead.
struct CommandLine {
  Options options;
  std::optional<std::string> text;  // help or version, for stdout
  std::vector<std::string> errors;  // for stderr, one per line
  std::size_t errors_left_out = 0;  // number of further errors in files
};

CommandLine parse_command_line(int argc, const char* const* argv);

}  // namespace gicube::emu
