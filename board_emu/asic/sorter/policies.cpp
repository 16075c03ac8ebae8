// A policy consists of a function here, its name in board_config.proto and its row below.
#include "asic/sorter/policies.h"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace gicube::emu {

namespace {

// Prefers the queue with most rays: its block serves most rays while it is in the cache [P §2.1].
std::uint32_t most_rays(const QueueFacts& queue) { return queue.waiting; }

// Prefers the queue whose rays can still add most to the image [P §2.1].
std::uint32_t most_contribution(const QueueFacts& queue) {
  return static_cast<std::uint32_t>(std::min<std::uint64_t>(queue.contribution, kMaxImportance));
}

// Prefers the queue whose first ray has waited longest: queues are served in the order in which they were opened [C].
// No queue starves. A small queue is served as soon as all those that were opened earlier.
std::uint32_t longest_wait(const QueueFacts& queue) {
  return kMaxImportance - std::min(queue.opened, kMaxImportance - 1);
}

}  // namespace

ImportanceOf importance_of(v1::QueuePolicy policy) {
  switch (policy) {
    case v1::most_rays: return most_rays;
    case v1::most_contribution: return most_contribution;
    case v1::longest_wait: return longest_wait;
    case v1::POLICY_UNSPECIFIED: break;
  }
  throw std::invalid_argument("sorter.policy: expected a policy of asic/sorter/policies.cpp, got " +
                              std::to_string(static_cast<int>(policy)));
}

bool reads_contribution(v1::QueuePolicy policy) { return policy == v1::most_contribution; }

}  // namespace gicube::emu
