// The channel's wires: when a packet may begin so that no two overlap on ROW, COL or DQ.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "rdram/timing.h"

namespace gicube::emu::rdram {

// The ROW wires, on which a later precharge may take a gap before an activation that is already placed. Remembers the
// last kWindow tCYCLE before the latest packet; what is older counts as taken. chosen: one machine word, eight activations.
class RowWires {
 public:
  static constexpr Tcycle kWindow = 64;

  // The first tCYCLE from which on gaps are known.
  Tcycle horizon() const { return base_; }
  // The earliest free begin of a packet from `t` on.
  Tcycle probe(Tcycle t) const {
    t = std::max(t, base_);
    const Tcycle offset = t - base_;
    if (offset >= kWindow) return t;
    return t + static_cast<unsigned>(std::countr_one(blocked_ >> offset));
  }
  // A packet begins at `t`, which probe() must have allowed.
  void reserve(Tcycle t) {
    const Tcycle last = t + kPacket - 1;  // the last begin that would overlap
    if (last >= base_ + kWindow) {
      const Tcycle shift = last + 1 - kWindow - base_;
      blocked_ = shift < kWindow ? blocked_ >> shift : 0;
      base_ += shift;
    }
    constexpr std::uint64_t kOverlaps = (std::uint64_t{1} << (2 * kPacket - 1)) - 1;
    const Tcycle first = t + 1 - std::min<Tcycle>(t + 1, kPacket);  // not before time began
    const std::uint64_t overlaps = kOverlaps >> (kPacket - 1 - (t - first));
    blocked_ |= first >= base_ ? overlaps << (first - base_) : overlaps >> (base_ - first);
  }

 private:
  Tcycle base_ = 0;
  std::uint64_t blocked_ = 0;  // bit i: no packet may begin at base_ + i
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
