// The binary tree of merging nodes that returns rays from the processors to the DSP, many to one [P §3.6].
//
// A node passes one ray per cycle, from its two inputs in turns, into a registered FIFO of two rays; the root's is the
// output. A leaf without a partner joins the next level. A ray takes one cycle per level, at most ceil(log2(leaves))
// and at least 1 [H317].
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <iosfwd>
#include <vector>

#include "asic/sim/fifo.h"
#include "gicube/archive.h"
#include "words/words.h"

namespace gicube::emu {

struct MergeTreeCounters {
  std::uint64_t rays = 0;   // rays that reached the output
  std::uint64_t waits = 0;  // cycles in which the root had a ray and the output was full
};

class MergeTree {
 public:
  // At least one leaf.
  MergeTree(const std::vector<Fifo<RayToken>*>& leaves, Fifo<RayToken>& output);

  MergeTree(const MergeTree&) = delete;  // its nodes point at one another
  MergeTree& operator=(const MergeTree&) = delete;

  bool tick(Cycle now) {
    // Usually there is nothing to merge.
    std::size_t rays = inside_;
    for (const auto& pair : leaf_pairs_) rays |= pair[0]->size() | pair[1]->size();
    return rays != 0 && work(now);
  }

  bool idle() const { return inside_ == 0; }  // no ray between leaves and output
  std::uint64_t inside() const { return inside_; }
  const MergeTreeCounters& counters() const { return counters_; }
  void dump(std::ostream& out) const;
  void state(Archive& archive) {
    archive.expect_idle(idle(), "the merge tree");
    archive("turns", nodes_);
    archive.field("counters", [this](Archive::Record& record) { record(counters_.rays, counters_.waits); });
    if (!archive.in_run()) return;
    archive("between", between_);
    inside_ = 0;
    for (const Fifo<RayToken>& fifo : between_) inside_ += fifo.size();
  }

 private:
  struct Node {
    std::array<Fifo<RayToken>*, 2> inputs{};  // the second may be missing: one leaf alone
    std::array<bool, 2> is_leaf{};
    Fifo<RayToken>* output = nullptr;
    std::uint8_t turn = 0;

    void state(Archive::Record& record) { record.at_most(turn, 1); }
  };

  bool work(Cycle now);
  bool merge(Node& node, Cycle now);

  std::deque<Fifo<RayToken>> between_;  // outputs of all nodes but the root
  std::vector<Node> nodes_;             // the root last
  std::vector<Fifo<RayToken>*> leaves_;
  std::vector<std::array<const Fifo<RayToken>*, 2>>
      leaf_pairs_;  // the leaves in pairs, which halves the loop; a leaf may be in two pairs
  std::uint64_t inside_ = 0;
  MergeTreeCounters counters_;
};

}  // namespace gicube::emu
