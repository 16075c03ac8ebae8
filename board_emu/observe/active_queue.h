// Which queue of a sorter was active in a cycle. The sorter chooses, issues and gives up within one, so what it holds at the
// cycle's end is not enough: a queue with a single ray is active for one cycle and leaves no trace in has_active().
#pragma once

#include <cstdint>
#include <optional>

#include "asic/sorter/sorter.h"

namespace gicube::emu {

class ActiveQueue {
 public:
  // After each cycle, or at least after the one before the first that matters.
  void see(const Sorter& sorter) {
    began_ = sorter.counters().activations != activations_;
    queue_ = began_ || held_ ? std::optional(sorter.latest_active()) : std::nullopt;
    activations_ = sorter.counters().activations;
    held_ = sorter.has_active();
  }

  // Of the cycle seen last.
  std::optional<std::uint32_t> queue() const { return queue_; }
  bool began() const { return began_; }
  bool ended() const { return queue_.has_value() && !held_; }

 private:
  std::uint64_t activations_ = 0;
  bool held_ = false;  // at the end of the cycle seen last
  bool began_ = false;
  std::optional<std::uint32_t> queue_;
};

}  // namespace gicube::emu
