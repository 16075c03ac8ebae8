// The merge tree (raybus/merge_tree.h) in rays instead of cycles: who is next when several are at its leaves. How long a ray
// takes to the root, and how many there is room for, is the processors' to know.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "asic/latencies.h"
#include "pass_queue.h"

namespace gicube::emu {

class PassTree {
 public:
  // Two leaves each, for finished and for overflowed rays.
  explicit PassTree(std::size_t processors)
      : leaves_(std::bit_ceil(2 * processors)), nodes_(2 * leaves_.size(), {kNoCycle, 0}) {}

  void push(std::uint8_t processor, const Arrival& ray) {
    const std::size_t leaf = 2u * processor + (ray.overflow() ? 1u : 0u);
    leaves_[leaf].push(ray);
    if (leaves_[leaf].size() == 1) first_changed(leaf);
  }

  // The cycle in which the first ray comes out; kNoCycle if there is none.
  Cycle ready() const { return nodes_[1].ready; }

  // As many are ready in cycle `now` as the FIFO behind the root holds.
  bool is_full(Cycle now) const {
    std::size_t ready = 0;
    for (const auto& leaf : leaves_) {
      for (std::size_t i = 0;
           i < std::min<std::size_t>(leaf.size(), kFifoPlaces) && leaf[leaf.begin() + i].ready <= now; ++i)
        ++ready;
    }
    return ready >= kFifoPlaces;
  }

  // One of those that are ready in cycle `now`: each node takes from both sides alternately.
  Arrival pop(Cycle now) {
    std::size_t node = 1;
    while (node < leaves_.size()) {
      const bool first = nodes_[2 * node].ready <= now, second = nodes_[2 * node + 1].ready <= now;
      const std::uint8_t side = first && second ? nodes_[node].next_side : std::uint8_t{second};
      nodes_[node].next_side = side ^ 1;
      node = 2 * node + side;
    }
    const Arrival ray = leaves_[node - leaves_.size()].pop();
    first_changed(node - leaves_.size());
    return ray;
  }
  // Between two runs: it is empty, and what is left is whose turn it is.
  void state(Archive::Record& record) {
    for (Node& node : nodes_) record.at_most(node.next_side, 1);
  }

 private:
  struct Node {
    Cycle ready;  // of the first below it
    std::uint8_t next_side;
  };

  void first_changed(std::size_t leaf) {
    std::size_t node = leaf + leaves_.size();
    nodes_[node].ready = leaves_[leaf].empty() ? kNoCycle : leaves_[leaf].front().ready;
    while ((node /= 2) > 0) nodes_[node].ready = std::min(nodes_[2 * node].ready, nodes_[2 * node + 1].ready);
  }

  std::vector<LongQueue<Arrival>> leaves_;
  std::vector<Node> nodes_;  // the root is the first, node n has 2 n and 2 n + 1 below it, the leaves are the last
};

}  // namespace gicube::emu
