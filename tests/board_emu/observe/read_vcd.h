// A plain reader of value change dumps, by the grammar of IEEE 1364 and with none of the writer's code.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace gicube::emu {

struct ReadVcd {
  std::string timescale;  // as "10 ns"
  // By "scope.name": value (binary digits, or "z") from a time on; the first entries are the initial values.
  struct Change {
    std::uint64_t time;
    std::string value;
  };
  std::map<std::string, std::vector<Change>> signals;
  std::map<std::string, unsigned> bits;
  std::uint64_t begin = 0;
  std::uint64_t end = 0;  // the last time

  // The value that holds at `time`.
  std::string at(const std::string& signal, std::uint64_t time) const;
};

// Throws std::runtime_error for what the grammar forbids: an id that was not declared, a time that goes back, a value
// with more digits than its signal, a "change" to the same value, a scope that stays open.
ReadVcd read_vcd(const std::string& text);

}  // namespace gicube::emu
