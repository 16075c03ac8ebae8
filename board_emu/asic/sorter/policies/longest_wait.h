// The queue whose first ray has waited longest: queues are served in the order in which they were opened [C]. No queue
// starves, and one that stays small is served as soon as all that were opened before it.
#pragma once

#include <algorithm>

#include "asic/sorter/policies/policy.h"

namespace gicube::emu {

inline std::uint32_t longest_wait(const QueueFacts& queue) {
  return kMaxImportance - std::min(queue.opened, kMaxImportance - 1);
}

}  // namespace gicube::emu
