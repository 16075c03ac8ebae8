// The wires of a channel: the times at which a packet may begin without overlapping another.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "asic/dram/constraint.h"
#include "gicube/archive.h"

namespace gicube::emu::dram {

// Wires on which a packet may use a gap before one that is already scheduled. A bitmap remembers the last clocks before
// the latest packet; older clocks count as taken. chosen: one machine word. The code has no branches, because random
// packets would make them unpredictable.
template <Tcycle kPacket>
class GapWires {
 public:
  // The first clock of the bitmap.
  Tcycle horizon() const { return base_; }
  // The earliest free begin of a packet from `t` on.
  Tcycle probe(Tcycle t) const {
    t = std::max(t, base_);
    const Tcycle bit = t - base_ + kReach;
    const std::uint64_t blocked = bit < kBits ? blocked_ >> bit : 0;
    return t + static_cast<unsigned>(std::countr_one(blocked));
  }
  // Schedules a packet at `t`, which probe() must have allowed.
  void reserve(Tcycle t) {
    constexpr std::uint64_t kOverlaps = (std::uint64_t{1} << (2 * kReach + 1)) - 1;
    const Tcycle last = t - base_ + 2 * kReach;  // bit of the last overlapping start
    const Tcycle shift = std::max(last, kBits - 1) - (kBits - 1);
    blocked_ = shift < kBits ? blocked_ >> shift : 0;
    base_ += shift;
    blocked_ |= kOverlaps << (t - base_);
  }
  void state(Archive::Record& record) {
    record.times(base_);
    record(blocked_);
  }

 private:
  static constexpr Tcycle kBits = 64;
  static constexpr Tcycle kReach = kPacket - 1;  // packets whose starts are this close overlap

  Tcycle base_ = 0;
  std::uint64_t blocked_ = 0;  // bit kReach + i: no packet may begin at base_ + i
};

// The wires of RD, WR and their data, strictly in order. The delays between RD and WR keep the data apart.
// `kSwitches`: data of another device than the last are delayed further.
template <bool kSwitches>
class ColumnWires {
 public:
  explicit ColumnWires(const ConstraintTable& timing) {
    for (const Command from : {Command::kRead, Command::kWrite}) {
      for (const Command to : {Command::kRead, Command::kWrite}) {
        delay_[is_write(from)][is_write(to)] = timing.delay(Scope::kChannel, from, to);
        other_delay_[is_write(from)][is_write(to)] = timing.delay(Scope::kOtherDevice, from, to);
      }
      data_[is_write(from)] = timing.delay(Scope::kChannel, from, Command::kData);
    }
  }

  Tcycle probe(Command command, std::uint16_t device, Tcycle t) const {
    const std::size_t to = is_write(command);
    t = std::max(t, ready_[to]);
    return kSwitches && device != last_device_ ? std::max(t, other_ready_[to]) : t;
  }
  void reserve(Command command, std::uint16_t device, Tcycle t) {
    for (const std::size_t to : {0u, 1u}) {
      ready_[to] = t + delay_[is_write(command)][to];
      if constexpr (kSwitches) other_ready_[to] = t + other_delay_[is_write(command)][to];
    }
    if constexpr (kSwitches) last_device_ = device;
  }
  // Start of the data of a packet that begins at `t`.
  Tcycle data(Command command, Tcycle t) const { return t + data_[is_write(command)]; }
  void state(Archive::Record& record) {
    record.times(ready_, other_ready_);
    record(last_device_);
  }

 private:
  static constexpr std::size_t is_write(Command command) { return command == Command::kWrite ? 1 : 0; }

  std::uint32_t delay_[2][2] = {}, other_delay_[2][2] = {};  // [from is write][to is write]
  std::uint32_t data_[2] = {};
  Tcycle ready_[2] = {}, other_ready_[2] = {};
  std::uint16_t last_device_ = 0;
};

}  // namespace gicube::emu::dram
