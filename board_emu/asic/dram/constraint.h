// A DRAM's timing as a table of constraints with the data book's names, for every memory standard.
//
// Times are clocks of the memory's interface. A command's time is the clock in which its packet begins on the wires.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace gicube::emu::dram {

using Tcycle = std::uint64_t;

inline constexpr Tcycle kNever = ~Tcycle{0};  // illegal at any time, because of the state

// kRefresh is REFA of an RDRAM, which opens a row, or REF of a DDR SDRAM, which needs all banks precharged. kData is a
// packet on the data wires.
enum class Command : std::uint8_t { kActivate, kPrecharge, kRead, kWrite, kRefresh, kData };
inline constexpr std::size_t kCommands = 6;

// A constraint holds between commands to one bank, to banks that share a sense amp, to one device, to any devices of
// the channel, or to two different devices.
enum class Scope : std::uint8_t { kBank, kNeighbour, kDevice, kChannel, kOtherDevice };
inline constexpr std::size_t kScopes = 5;

constexpr std::size_t index(Command command) { return static_cast<std::size_t>(command); }
constexpr std::size_t index(Scope scope) { return static_cast<std::size_t>(scope); }

constexpr const char* to_string(Command command) {
  constexpr std::array kNames{"ACT", "PRE", "RD", "WR", "REFA", "DATA"};
  return kNames[index(command)];
}
constexpr const char* to_string(Scope scope) {
  constexpr std::array kNames{"bank", "neighbour", "device", "channel", "other device"};
  return kNames[index(scope)];
}

// `to` may begin `cycles` after `from` began, not earlier. With `to` = kData: the data begin exactly then.
struct Constraint {
  std::string name;
  Command from;
  Command to;
  Scope scope;
  std::uint32_t cycles;

  friend bool operator==(const Constraint&, const Constraint&) = default;
};

using Delays = std::array<std::array<std::array<std::uint32_t, kCommands>, kCommands>, kScopes>;

class ConstraintTable {
 public:
  using Enforced = bool (*)(Scope scope, Command from, Command to);

  // Throws std::invalid_argument if the standard's model does not enforce a row.
  ConstraintTable(std::string_view standard, Enforced enforced, std::vector<Constraint> rows) : rows_(std::move(rows)) {
    for (const Constraint& row : rows_) {
      if (!enforced(row.scope, row.from, row.to)) {
        throw std::invalid_argument(std::string(standard) + " timing " + row.name +
                                    ": expected a pair of commands that the model enforces, got " +
                                    to_string(row.from) + " to " + to_string(row.to) + " in a " + to_string(row.scope));
      }
      std::uint32_t& delay = delays_[index(row.scope)][index(row.from)][index(row.to)];
      delay = std::max(delay, row.cycles);
    }
  }

  const std::vector<Constraint>& rows() const { return rows_; }
  const Delays& delays() const { return delays_; }
  // The longest delay of the table's rows for this pair; 0 without a row.
  std::uint32_t delay(Scope scope, Command from, Command to) const {
    return delays_[index(scope)][index(from)][index(to)];
  }

 private:
  std::vector<Constraint> rows_;
  Delays delays_{};
};

}  // namespace gicube::emu::dram
