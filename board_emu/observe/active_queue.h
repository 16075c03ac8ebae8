// Determines which queue of a sorter was active in a cycle. has_active() at the end of the cycle is not enough: a queue
// with a single ray becomes active, issues its ray and is deactivated in the same cycle.
#pragma once

#include <cstdint>
#include <optional>

#include "asic/sorter/sorter.h"

namespace gicube::emu {

class ActiveQueue {
 public:
  // To be called after each cycle of interest, and after the cycle before the first of them.
  void see(const Sorter& sorter) {
    began_ = sorter.counters().activations != activations_;
    queue_ = began_ || held_ ? std::optional(sorter.latest_active()) : std::nullopt;
    activations_ = sorter.counters().activations;
    held_ = sorter.has_active();
  }

  // The queue that was active in the latest cycle, if any.
  std::optional<std::uint32_t> queue() const { return queue_; }
  bool began() const { return began_; }
  bool ended() const { return queue_.has_value() && !held_; }

 private:
  std::uint64_t activations_ = 0;
  bool held_ = false;  // a queue was active at the end of the latest cycle
  bool began_ = false;
  std::optional<std::uint32_t> queue_;
};

}  // namespace gicube::emu
