// The most important of all queues, known at once: the bound that a perfect sorter would reach [C].
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace gicube::emu {

// A tree of winners over the queues' importances. Equal ones: the lower queue number wins.
class ExactMaximum {
 public:
  explicit ExactMaximum(std::uint32_t queues) : leaves_(std::bit_ceil(queues)), importance_(2 * std::size_t{leaves_}) {}

  void set(std::uint32_t queue, std::uint32_t importance) {
    std::uint32_t node = leaves_ + queue;
    importance_[node] = importance;
    while (node > 1) {
      node /= 2;
      const std::uint32_t larger = std::max(importance_[2 * node], importance_[2 * node + 1]);
      if (importance_[node] == larger) return;
      importance_[node] = larger;
    }
  }

  // The largest; 0 if there is none.
  std::uint32_t importance() const { return importance_[1]; }
  // Only if some importance is above 0.
  std::uint32_t queue() const {
    std::uint32_t node = 1;
    while (node < leaves_) node = 2 * node + (importance_[2 * node] == importance_[node] ? 0 : 1);
    return node - leaves_;
  }

 private:
  std::uint32_t leaves_;
  std::vector<std::uint32_t> importance_;  // node 1 is the root
};

}  // namespace gicube::emu
