// The RDRAM's timing as a table of constraints with the data book's names.
//
// Convention: every time is a tCYCLE (2.5 ns at 800 MHz), and a command's time is the tCYCLE in which its packet begins on
// the ROW or COL wires. All packets last tPACK = 4, so an interval between two packets is the same from end to end, as the
// data book counts it, as from begin to begin, as this table counts it. Where the data book counts from one packet's end
// to another's begin, the row adds tPACK: data begin tPACK + tCAC after the begin of the RD packet, and a read of a
// device that was just written waits tRTR + tPACK, since the packet that retires the write buffer goes between.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "gicube/v1/board_config.pb.h"

namespace gicube::emu::rdram {

using Tcycle = std::uint64_t;

inline constexpr Tcycle kNever = ~Tcycle{0};  // the state, not the time, forbids it
inline constexpr std::uint32_t kPacket = 4;   // tPACK: a packet of ROW, COL or DQ (Siemens HYB25x144180C)

// kRefresh is REFA: it opens the row of the device's own refresh counter. kData is a dualoct on the DQ wires.
enum class Command : std::uint8_t { kActivate, kPrecharge, kRead, kWrite, kRefresh, kData };
inline constexpr std::size_t kCommands = 6;

// Between commands to one bank, to banks that share a sense amp, to one device, or to any device of the channel.
enum class Scope : std::uint8_t { kBank, kNeighbour, kDevice, kChannel };
inline constexpr std::size_t kScopes = 4;

constexpr std::size_t index(Command command) { return static_cast<std::size_t>(command); }
constexpr std::size_t index(Scope scope) { return static_cast<std::size_t>(scope); }

const char* to_string(Command command);
const char* to_string(Scope scope);

// `to` may begin `cycles` after `from` began, not earlier. With `to` = kData: the data begin exactly then.
struct Constraint {
  std::string name;
  Command from;
  Command to;
  Scope scope;
  std::uint32_t cycles;

  friend bool operator==(const Constraint&, const Constraint&) = default;
};

// Pairs between which the model can hold a constraint; a table may have no others.
constexpr bool honoured(Scope scope, Command from, Command to) {
  constexpr auto opens = [](Command c) { return c == Command::kActivate || c == Command::kRefresh; };
  constexpr auto column = [](Command c) { return c == Command::kRead || c == Command::kWrite; };
  constexpr auto row = [opens](Command c) { return opens(c) || c == Command::kPrecharge; };
  switch (scope) {
    case Scope::kBank:
      return (opens(from) && row(to)) || (from == Command::kActivate && column(to)) ||
             (from == Command::kPrecharge && opens(to)) || (column(from) && to == Command::kPrecharge);
    case Scope::kNeighbour: return from == Command::kPrecharge && opens(to);
    case Scope::kDevice:
      return (opens(from) && opens(to)) || (from == Command::kPrecharge && to == Command::kPrecharge) ||
             (from == Command::kWrite && to == Command::kRead);
    case Scope::kChannel:
      return (row(from) && row(to)) || (column(from) && column(to)) || (column(from) && to == Command::kData);
  }
  return false;
}

class Timing {
 public:
  explicit Timing(const v1::RdramConfig& config);
  // Throws std::invalid_argument if a row names a pair that is not honoured().
  explicit Timing(std::vector<Constraint> rows);

  const std::vector<Constraint>& rows() const { return rows_; }
  // The longest of the table's rows for this pair; 0 if there is none.
  std::uint32_t delay(Scope scope, Command from, Command to) const {
    return delays_[index(scope)][index(from)][index(to)];
  }

 private:
  std::vector<Constraint> rows_;
  std::array<std::array<std::array<std::uint32_t, kCommands>, kCommands>, kScopes> delays_{};
};

}  // namespace gicube::emu::rdram
