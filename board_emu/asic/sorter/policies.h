// Queue policies: what a queue's importance is, from what the queues know of it. The sorter takes the most important queue.
#pragma once

#include <cstdint>

#include "gicube/v1/board_config.pb.h"

namespace gicube::emu {

// Of a queue in which rays wait.
struct QueueFacts {
  std::uint32_t waiting = 0;       // rays
  std::uint32_t opened = 0;        // how many queues got a first ray before this one got its own
  std::uint64_t contribution = 0;  // the sum of its rays', at least 1 each
};

// The active queue's importance is infinite; no policy gives more than this, nor 0, which an empty queue has.
inline constexpr std::uint32_t kMaxImportance = ~std::uint32_t{0} - 1;

using ImportanceOf = std::uint32_t (*)(const QueueFacts&);

// Throws std::invalid_argument for a policy that has no row.
ImportanceOf importance_of(v1::QueuePolicy policy);

// Whether it reads QueueFacts::contribution. A waiting ray must then have the words of its place: no level may compute its
// end ahead.
bool reads_contribution(v1::QueuePolicy policy);

}  // namespace gicube::emu
