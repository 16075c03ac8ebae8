// The channel's wires: when a packet may begin so that no two overlap on ROW, COL or DQ.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "asic/dram/gap_wires.h"
#include "asic/rdram/timing.h"

namespace gicube::emu::rdram {

// The ROW wires, on which a later precharge may take a gap before an activation that is already placed.
using RowWires = dram::GapWires<kPacket>;

// The COL wires, strictly in order; the order there also keeps the data apart on DQ.
class ColumnWires {
 public:
  explicit ColumnWires(const Timing& timing) {
    for (const Command from : {Command::kRead, Command::kWrite}) {
      for (const Command to : {Command::kRead, Command::kWrite}) {
        delay_[from == Command::kWrite][to == Command::kWrite] = timing.delay(Scope::kChannel, from, to);
      }
      data_[from == Command::kWrite] = timing.delay(Scope::kChannel, from, Command::kData);
    }
  }

  template <Command kCommand>
  Tcycle probe(Tcycle t) const {
    return std::max(t, ready_[kCommand == Command::kWrite]);
  }
  template <Command kCommand>
  void reserve(Tcycle t) {
    for (const std::size_t to : {0u, 1u}) ready_[to] = t + delay_[kCommand == Command::kWrite][to];
  }
  // When the data of a packet that begins at `t` begin.
  template <Command kCommand>
  Tcycle data(Tcycle t) const {
    return t + data_[kCommand == Command::kWrite];
  }

 private:
  std::uint32_t delay_[2][2] = {};  // [from is write][to is write]
  std::uint32_t data_[2] = {};
  Tcycle ready_[2] = {};
};

}  // namespace gicube::emu::rdram
