// Errors of the volume's memory. A command that encounters a detected one is not executed.
#pragma once

#include <deque>

#include "card.h"

namespace gicube::emu {

class MemoryErrors {
 public:
  explicit MemoryErrors(Card& card) : card_(card) {}

  // See Board::add_memory_error().
  void add(const MemoryError& error);
  // To be called by each command: throws CommandFault if a detected error has not been reported.
  void expect_none() {
    if (!waiting_.empty()) meet();
  }
  void clear() { waiting_.clear(); }
  std::deque<MemoryError>& waiting() { return waiting_; }

 private:
  [[noreturn]] void meet();

  Card& card_;
  std::deque<MemoryError> waiting_;  // detected, and reported by no command yet
};

}  // namespace gicube::emu
