// The channel's wires: when a packet may begin so that no two overlap on ROW, COL or DQ.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "asic/rdram/timing.h"

namespace gicube::emu::rdram {

// The ROW wires, on which a later precharge may take a gap before an activation that is already placed. Remembers the
// last tCYCLEs before the latest packet; what is older counts as taken. chosen: one machine word, seven activations. No
// branches: with random packets nothing here can be predicted.
class RowWires {
 public:
  // The first tCYCLE from which on gaps are known.
  Tcycle horizon() const { return base_; }
  // The earliest free begin of a packet from `t` on.
  Tcycle probe(Tcycle t) const {
    t = std::max(t, base_);
    const Tcycle bit = t - base_ + kReach;
    const std::uint64_t blocked = bit < kBits ? blocked_ >> bit : 0;
    return t + static_cast<unsigned>(std::countr_one(blocked));
  }
  // A packet begins at `t`, which probe() must have allowed.
  void reserve(Tcycle t) {
    constexpr std::uint64_t kOverlaps = (std::uint64_t{1} << (2 * kReach + 1)) - 1;
    const Tcycle last = t - base_ + 2 * kReach;  // bit of the last begin that would overlap
    const Tcycle shift = std::max(last, kBits - 1) - (kBits - 1);
    blocked_ = shift < kBits ? blocked_ >> shift : 0;
    base_ += shift;
    blocked_ |= kOverlaps << (t - base_);
  }

 private:
  static constexpr Tcycle kBits = 64;
  static constexpr Tcycle kReach = kPacket - 1;  // packets that begin so near overlap

  Tcycle base_ = 0;
  std::uint64_t blocked_ = 0;  // bit kReach + i: no packet may begin at base_ + i
};

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
