// The command line of gicube-smi, and its commands.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace gicube::smi {

struct Options;
int overview(const Options& options);  // without a command

struct Options {
  // The requested command. It prints to standard output and returns the exit code: 0 success, 1 failure.
  int (*run)(const Options&) = &overview;
  bool json = false;

  // The management plane: list, info, top, reset, faults, trace; doctor looks at it too if it is named.
  std::string management;  // unix:PATH or tcp:HOST:PORT; empty: that of the only local process
  std::string ca_file;     // TLS: the certificate that signed the board's; empty: no TLS
  std::string token_file;
  std::uint32_t board = 0;

  std::string uri = "emu:";  // validate, doctor
  std::uint32_t interval_ms = 1000;
  std::uint32_t count = 0;  // top: snapshots; 0 = until it is interrupted
  bool all_counters = false;
  std::string plan_file;  // faults set; "-" = standard input
  bool clear_log = false;
  std::string trace_file;
  std::string listen;             // export: ADDRESS:PORT
  std::string shown_file;         // show
  std::string checkpoint_file;    // checkpoint
  std::string script_file = "-";  // debug; "-" = standard input
};

// Wrong usage: exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// The content of a file that `option` names. Throws UsageError.
std::string read_file(const char* option, const std::string& path);

// The commands (Options::run).
int list(const Options& options);
int info(const Options& options);
int top(const Options& options);
int validate(const Options& options);
int reset(const Options& options);
int show_faults(const Options& options);
int set_faults(const Options& options);
int clear_faults(const Options& options);
int log_faults(const Options& options);
int show_trace(const Options& options);
int start_trace(const Options& options);
int stop_trace(const Options& options);
int debug(const Options& options);
int checkpoint(const Options& options);
int doctor(const Options& options);
int export_metrics(const Options& options);
int show(const Options& options);

}  // namespace gicube::smi
