// The common options of all samples: the board, its configuration, and the output about the run.
#pragma once

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <stdexcept>
#include <string>
#include <vector>

#include "gicube/scene/provenance.h"
#include "gicube/vector.h"
#include "scene/names.h"

namespace gicube::samples {

// The command line is wrong: exit code 2.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The program, its version and the last command line of parsed().
Provenance this_run();

// Parses the command line of a program. False if help or the version was requested, and written to `out`. Throws
// UsageError with one line.
bool parsed(CLI::App& app, int argc, const char* const* argv, std::ostream& out);

struct BoardOptions {
  std::string board = "emu:";
  std::vector<std::string> others;    // boards besides that one
  bool own_buses = false;             // each of several boards has its own bus
  std::string fidelity;               // empty: the board's own
  std::filesystem::path config;       // empty: none
  std::vector<std::string> settings;  // path.to.field=value
  std::filesystem::path stats;        // empty: none
  std::uint64_t seed = 0;
  int threads = 0;                     // 0 = one per core
  std::chrono::seconds watchdog{600};  // for one answer of the board, wall clock; 0 = none
  bool quiet = false;
  std::filesystem::path events;   // output of the emulated board's events; empty: none
  std::string events_of;          // the rays with events (docs/guide/observation.md)
  std::filesystem::path restore;  // a checkpoint of Board::save() from which the board continues; empty: none

  bool has_own_level = false;  // the program has chosen the level
  // Sets another level than the user's.
  void set_level(const char* level) {
    fidelity = level;
    has_own_level = true;
  }
};

// Adds --board --fidelity --config --set --stats --seed --threads --watchdog --quiet, as the group "Board and run".
// `several`: --board may be given several times, and there is --own-buses.
void add_board_options(CLI::App& app, BoardOptions& options, bool several = false);

// The URI for Board::open(): emu: with the options as its query. Throws UsageError for options that configure a running
// board (unix:, tcp:), which has its own configuration.
std::string board_uri(const BoardOptions& options);
// URIs of all boards.
std::vector<std::string> board_uris(const BoardOptions& options);

// Numbers separated by commas: "1,2.5,-3". Throws CLI::ValidationError with `option` and an example unless there are
// `count` finite ones, 1 to 4.
std::vector<double> parse_numbers(const std::string& option, const std::string& text, std::size_t count);
Vec3 parse_vector(const std::string& option, const std::string& text);
// Whole numbers from 1: "WxH" with separator 'x' and count 2, or "X,Y,Z" with ',' and 3.
std::vector<int> parse_sizes(const std::string& option, const std::string& text, std::size_t count, char separator);

}  // namespace gicube::samples
