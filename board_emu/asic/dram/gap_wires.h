// Wires on which a later packet may take a gap before one that is already placed: when a packet may begin so that no two
// overlap.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "asic/dram/constraint.h"

namespace gicube::emu::dram {

// Packets of kPacket clocks. Remembers the last clocks before the latest packet; what is older counts as taken. chosen: one
// machine word. No branches: with random packets nothing here can be predicted.
template <Tcycle kPacket>
class GapWires {
 public:
  // The first clock from which on gaps are known.
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

}  // namespace gicube::emu::dram
