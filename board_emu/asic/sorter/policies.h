// Queue policies: functions from the facts about a queue to its importance. The sorter takes the most important queue.
#pragma once

#include <cstdint>

#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

// Facts about a queue in which rays wait.
struct QueueFacts {
  std::uint32_t waiting = 0;       // rays
  std::uint32_t opened = 0;        // number of queues that were opened before this one
  std::uint64_t contribution = 0;  // sum over its rays, at least 1 each
};

// The largest importance that a policy may return. The active queue's is infinite, an empty queue's is 0; policies
// return neither.
inline constexpr std::uint32_t kMaxImportance = ~std::uint32_t{0} - 1;

using ImportanceOf = std::uint32_t (*)(const QueueFacts&);

// Throws std::invalid_argument for a policy that has no row.
ImportanceOf importance_of(v1::QueuePolicy policy);

// Whether the policy reads QueueFacts::contribution. A waiting ray must then carry its current state: no level may
// compute its end in advance.
bool reads_contribution(v1::QueuePolicy policy);

}  // namespace gicube::emu
