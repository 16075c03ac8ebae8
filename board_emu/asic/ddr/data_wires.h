// The data wires of the channel: RD and WR keep the order of requests, and no two packets' data meet there.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "asic/ddr/timing.h"

namespace gicube::emu::ddr {

class DataWires {
 public:
  explicit DataWires(const Timing& timing) {
    for (const Command from : {Command::kRead, Command::kWrite}) {
      for (const Command to : {Command::kRead, Command::kWrite}) {
        same_[is_write(from)][is_write(to)] = timing.delay(Scope::kChannel, from, to);
        other_[is_write(from)][is_write(to)] = timing.delay(Scope::kOtherDevice, from, to);
      }
      data_[is_write(from)] = timing.delay(Scope::kChannel, from, Command::kData);
    }
  }

  Tcycle probe(Command command, std::uint16_t rank, Tcycle t) const {
    const std::size_t to = is_write(command);
    return std::max({t, ready_[to], rank == last_rank_ ? 0 : other_ready_[to]});
  }
  // Commands come in the order of their times, so that the last one's wait for another rank is the longest.
  void reserve(Command command, std::uint16_t rank, Tcycle t) {
    const std::size_t from = is_write(command);
    for (const std::size_t to : {0u, 1u}) {
      ready_[to] = std::max(ready_[to], t + same_[from][to]);
      other_ready_[to] = t + other_[from][to];
    }
    last_rank_ = rank;
  }
  // When the data of a command that begins at `t` begin.
  Tcycle data(Command command, Tcycle t) const { return t + data_[is_write(command)]; }

 private:
  static constexpr std::size_t is_write(Command command) { return command == Command::kWrite ? 1 : 0; }

  std::uint32_t same_[2][2] = {}, other_[2][2] = {};  // [from is write][to is write]
  std::uint32_t data_[2] = {};
  std::array<Tcycle, 2> ready_{}, other_ready_{};
  std::uint16_t last_rank_ = 0;
};

}  // namespace gicube::emu::ddr
