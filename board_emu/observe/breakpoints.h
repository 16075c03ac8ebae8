// Breakpoints of the debugger: conditions on the machine's state, evaluated after each cycle, and on the steps of rays.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cycle/machine.h"

namespace gicube::emu {

// Converts core cycles of a command to simulated time.
struct CommandClock {
  Picoseconds begin_ps = 0;  // start of the present command
  Cycle begin_cycle = 0;
  std::uint64_t core_khz = 1;

  Picoseconds time(Cycle cycle) const { return begin_ps + cycles_to_ps(cycle - begin_cycle, core_khz); }
};

struct Breakpoint {
  unsigned number = 0;
  std::string text;  // the client's words

  // Each may be empty. The first three return the reason to pause, or nothing.
  std::function<std::optional<std::string>(Cycle now, const Machine& machine)> on_cycle{};
  std::function<std::optional<std::string>(const RayEvent& event, const Machine& machine)> on_ray{};
  std::function<std::optional<std::string>(const std::vector<wire::Counter>& counters)> on_counters{};
  std::function<bool(std::uint64_t ray, const wire::Ray& made)> watches{};
  std::optional<std::uint32_t> ticket{};  // limits it to the command with this ticket
  bool on_command = false;
  std::optional<Cycle> cycle{};  // first cycle in which on_cycle can be met
};

// Parses "cycle N", "time 12.5us", "ray N", "ray TICKET:N", "pixel X Y", "voxel X Y Z", "block X Y Z", "queue P Q
// FILL", "overflow", "trap", "conflict", "counter NAME VALUE" or "command". Throws std::invalid_argument, "expected
// ..., got ...".
Breakpoint parse_breakpoint(const std::vector<std::string>& words, const CommandClock& clock);

// Breakpoint after `count` further units: "cycle", "sample" or "ray" (a finished ray). Throws std::invalid_argument.
Breakpoint step_of(const std::string& unit, std::uint64_t count, Cycle now, const Machine& machine);

// A ray as the client names it: "N", in any command, or "TICKET:N".
struct RayName {
  std::optional<std::uint32_t> ticket{};
  std::uint64_t number = 0;
};
RayName ray_at(const std::vector<std::string>& words, std::size_t at);

// Number of queues of a processor.
std::size_t queues_of(std::size_t processor, const Machine& machine);

// Returns the number at words[at]. Throws std::invalid_argument, which states `what` was expected.
std::uint64_t number_at(const std::vector<std::string>& words, std::size_t at, const char* what);

}  // namespace gicube::emu
