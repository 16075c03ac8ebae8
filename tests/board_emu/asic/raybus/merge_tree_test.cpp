// The merge tree: depth, fairness, conservation.
#include "asic/raybus/merge_tree.h"

#include "test.h"

namespace gicube::emu {
namespace {

struct TreeRig {
  explicit TreeRig(std::size_t count, std::size_t places = 4, std::size_t output_places = 4)
      : leaves(count, Fifo<RayToken>(places)), output(output_places), tree(pointers(), output) {}

  std::vector<Fifo<RayToken>*> pointers() {
    std::vector<Fifo<RayToken>*> all;
    for (Fifo<RayToken>& leaf : leaves) all.push_back(&leaf);
    return all;
  }

  std::vector<Fifo<RayToken>> leaves;
  Fifo<RayToken> output;
  MergeTree tree;
};

// Cycles from the leaf's FIFO to the output's.
Cycle latency(std::size_t leaves, std::size_t leaf) {
  TreeRig rig(leaves);
  rig.leaves[leaf].push(0, {.ray = 5});
  for (Cycle now = 1; now < 100; ++now) {
    if (rig.output.can_pop(now)) {
      EXPECT_EQ(rig.output.front().ray, 5u);
      EXPECT_TRUE(rig.tree.idle());
      return now - 1;
    }
    rig.tree.tick(now);
  }
  return kNoCycle;
}

TEST(MergeTree, TakesOneCycleALevel) {
  EXPECT_EQ(latency(1, 0), 1u);
  for (const std::size_t leaves : {2u, 4u, 8u, 32u}) {
    const auto depth = static_cast<Cycle>(std::bit_width(leaves) - 1);
    for (std::size_t leaf = 0; leaf < leaves; ++leaf) EXPECT_EQ(latency(leaves, leaf), depth) << leaves << ' ' << leaf;
  }
}

TEST(MergeTree, BringsALeafWithoutPartnerUpSooner) {
  EXPECT_EQ(latency(3, 0), 2u);
  EXPECT_EQ(latency(3, 2), 1u);
  EXPECT_EQ(latency(6, 5), 2u);
}

// Rays a leaf gets through in `cycles` while the leaves of `busy` never run dry.
std::vector<int> shares(std::size_t leaves, const std::vector<bool>& busy, Cycle cycles) {
  TreeRig rig(leaves);
  std::vector<int> share(leaves, 0);
  for (Cycle now = 0; now < cycles; ++now) {
    for (std::uint32_t i = 0; i < leaves; ++i) {
      if (busy[i] && rig.leaves[i].can_push(now)) rig.leaves[i].push(now, {.ray = i});
    }
    rig.tree.tick(now);
    if (rig.output.can_pop(now)) ++share[rig.output.pop(now).ray];
  }
  return share;
}

TEST(MergeTree, PassesOneRayACycleAndSharesItEvenly) {
  const std::vector<int> share = shares(4, {true, true, true, true}, 404);
  EXPECT_GE(std::accumulate(share.begin(), share.end(), 0), 400);  // but for the first rays' latency
  for (const int rays : share) EXPECT_NEAR(rays, 100, 1);
}

TEST(MergeTree, GivesALoneLeafTheFullRate) {
  EXPECT_EQ(shares(8, {false, false, true, false, false, false, false, false}, 104)[2], 100);
}

TEST(MergeTree, HoldsRaysBackWhileTheOutputIsFull) {
  TreeRig rig(4, 4, 1);
  for (Cycle now = 0; now < 50; ++now) {
    for (Fifo<RayToken>& leaf : rig.leaves) {
      if (leaf.can_push(now)) leaf.push(now, {});
    }
    rig.tree.tick(now);
  }
  EXPECT_EQ(rig.tree.counters().rays, 1u);
  EXPECT_EQ(rig.tree.inside(), 4u);           // two nodes below the root, two rays each
  EXPECT_EQ(rig.tree.counters().waits, 47u);  // one ray went out in cycle 2
  for (const Fifo<RayToken>& leaf : rig.leaves) EXPECT_EQ(leaf.size(), 4u);
}

TEST(MergeTree, LosesAndDoublesNoRayUnderRandomTraffic) {
  for (const std::size_t leaves : {1u, 2u, 3u, 5u, 7u, 8u, 32u}) {
    constexpr std::uint32_t kRays = 2000;
    TreeRig rig(leaves, 2, 2);
    std::mt19937 random(static_cast<unsigned>(leaves));
    std::vector<int> seen(kRays, 0);
    std::uint32_t made = 0, got = 0;
    for (Cycle now = 0; got < kRays && now < 20'000; ++now) {
      for (Fifo<RayToken>& leaf : rig.leaves) {
        if (made < kRays && random() % leaves == 0 && leaf.can_push(now)) leaf.push(now, {.ray = made++});
      }
      rig.tree.tick(now);
      if (random() % 4 != 0 && rig.output.can_pop(now)) {
        ++seen[rig.output.pop(now).ray];
        ++got;
      }
    }
    EXPECT_EQ(seen, std::vector<int>(kRays, 1)) << leaves;
    EXPECT_TRUE(rig.tree.idle());
    EXPECT_EQ(rig.tree.counters().rays, kRays);
  }
}

TEST(MergeTree, DescribesWhereRaysStand) {
  TreeRig rig(2);
  rig.leaves[1].push(0, {});
  std::ostringstream text;
  rig.tree.dump(text);
  EXPECT_EQ(text.str(), "merge tree: 0 rays inside, 0 at its output; at its leaves 0 1\n");
}

}  // namespace
}  // namespace gicube::emu
