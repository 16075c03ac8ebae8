#include "asic/raybus/merge_tree.h"

#include <algorithm>
#include <cassert>
#include <ostream>

namespace gicube::emu {

namespace {
constexpr std::size_t kNodeRays = 2;  // keeps full rate (sim/fifo.h)
}

MergeTree::MergeTree(const std::vector<Fifo<RayToken>*>& leaves, Fifo<RayToken>& output) : leaves_(leaves) {
  assert(!leaves.empty());
  const auto is_leaf = [&](const Fifo<RayToken>* fifo) { return std::count(leaves.begin(), leaves.end(), fifo) > 0; };
  for (std::size_t i = 0; i < leaves.size(); i += 2) {
    leaf_pairs_.push_back({leaves[i], leaves[std::min(i + 1, leaves.size() - 1)]});
  }
  std::vector<Fifo<RayToken>*> level = leaves;
  do {
    std::vector<Fifo<RayToken>*> above;
    for (std::size_t i = 0; i < level.size(); i += 2) {
      if (i + 1 == level.size() && level.size() > 1) {
        above.push_back(level[i]);
        continue;
      }
      Fifo<RayToken>& to = level.size() <= 2 ? output : between_.emplace_back(kNodeRays);
      Fifo<RayToken>* const partner = i + 1 < level.size() ? level[i + 1] : nullptr;
      nodes_.push_back({{level[i], partner}, {is_leaf(level[i]), is_leaf(partner)}, &to, 0});
      above.push_back(&to);
    }
    level = above;
  } while (level.size() > 1);
}

bool MergeTree::work(Cycle now) {
  bool moved = false;
  for (Node& node : nodes_) moved |= merge(node, now);
  return moved;
}

bool MergeTree::merge(Node& node, Cycle now) {
  const bool first = node.inputs[0]->can_pop(now);
  const bool second = node.inputs[1] != nullptr && node.inputs[1]->can_pop(now);
  if (!first && !second) return false;
  const bool is_root = &node == &nodes_.back();
  if (!node.output->can_push(now)) {
    if (is_root) ++counters_.waits;
    return false;
  }
  const std::uint8_t from = first && second ? node.turn : static_cast<std::uint8_t>(second ? 1 : 0);
  node.output->push(now, node.inputs[from]->pop(now));
  node.turn = from ^ 1;
  if (node.is_leaf[from]) ++inside_;
  if (is_root) {
    --inside_;
    ++counters_.rays;
  }
  return true;
}

void MergeTree::dump(std::ostream& out) const {
  out << "merge tree: " << inside_ << " rays inside, " << (nodes_.back().output->size())
      << " at its output; at its leaves";
  for (const Fifo<RayToken>* leaf : leaves_) out << ' ' << leaf->size();
  out << '\n';
}

}  // namespace gicube::emu
