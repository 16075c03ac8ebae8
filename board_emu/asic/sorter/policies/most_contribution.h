// The queue whose rays can still add most to the image [P §2.1].
#pragma once

#include <algorithm>

#include "asic/sorter/policies/policy.h"

namespace gicube::emu {

inline std::uint32_t most_contribution(const QueueFacts& queue) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(queue.contribution, kMaxImportance));
}

}  // namespace gicube::emu
