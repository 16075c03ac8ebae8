// The queue with most rays: its block serves most rays while it is in the cache [P §2.1].
#pragma once

#include "asic/sorter/policies/policy.h"

namespace gicube::emu {

inline std::uint32_t most_rays(const QueueFacts& queue) { return queue.waiting; }

}  // namespace gicube::emu
