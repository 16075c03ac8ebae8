#include "lookahead.h"

#include <algorithm>

namespace gicube::emu {

void Lookahead::begin(Cycle now, const std::vector<std::unique_ptr<Processor>>& processors,
                      const std::vector<std::unique_ptr<MemoryPort>>& memories) {
  parts_.clear();
  for (std::size_t i = 0; i < processors.size(); ++i) {
    parts_.push_back({.processor = processors[i].get(), .memory = memories[i].get(), .ahead_until = now, .next = now});
  }
}

Cycle Lookahead::catch_up_all(Cycle to) {
  Cycle moved = 0;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].ahead_until >= to) moved = std::max(moved, catch_up(i, to));
  }
  return moved;
}

}  // namespace gicube::emu
