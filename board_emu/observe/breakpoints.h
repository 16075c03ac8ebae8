// What a debugger stops a machine at: conditions on its state, looked at after each cycle, and on the steps of rays.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cycle/machine.h"

namespace gicube::emu {

// A place of the timeline: a core cycle, and its simulated time.
struct CommandClock {
  Picoseconds begin_ps = 0;  // of the command in work
  Cycle begin_cycle = 0;
  std::uint64_t core_khz = 1;

  Picoseconds time(Cycle cycle) const { return begin_ps + cycles_to_ps(cycle - begin_cycle, core_khz); }
};

struct Breakpoint {
  unsigned number = 0;
  std::string text;  // as it was given

  // Each may be missing. They answer why the machine is to stop, or nothing.
  std::function<std::optional<std::string>(Cycle now, const Machine& machine)> on_cycle{};
  std::function<std::optional<std::string>(const RayEvent& event, const Machine& machine)> on_ray{};
  std::function<std::optional<std::string>(const std::vector<wire::Counter>& counters)> on_counters{};
  std::function<bool(std::uint64_t ray, const wire::Ray& made)> watches{};
  std::optional<std::uint32_t> ticket{};  // only in the command of this ticket
  bool on_command = false;
  std::optional<Cycle> cycle{};  // on_cycle need not be asked before
};

// "cycle N", "time 12.5us", "ray N", "ray TICKET:N", "pixel X Y", "voxel X Y Z", "block X Y Z", "queue P Q FILL", "overflow", "trap", "conflict",
// "counter NAME VALUE", "command". Throws std::invalid_argument, "expected ..., got ...".
Breakpoint parse_breakpoint(const std::vector<std::string>& words, const CommandClock& clock);

// The end of a step of `count` cycles, samples or rays from now on.
Breakpoint step_of(const std::string& unit, std::uint64_t count, Cycle now, const Machine& machine);

// "N", a ray of any command, or "TICKET:N".
struct RayName {
  std::optional<std::uint32_t> ticket{};
  std::uint64_t number = 0;
};
RayName ray_at(const std::vector<std::string>& words, std::size_t at);

// The number at words[at]; `what` names it in the fault.
std::uint64_t number_at(const std::vector<std::string>& words, std::size_t at, const char* what);

}  // namespace gicube::emu
