// The queues and the merge tree of the approximate level.
#include <gtest/gtest.h>

#include <vector>

#include "approximate/pass_tree.h"

namespace gicube::emu {
namespace {

TEST(LongQueue, ItemsKeepTheirNumbersWhenItGrows) {
  LongQueue<int> queue;
  for (int i = 0; i < 10; ++i) queue.push(i);
  for (int i = 0; i < 7; ++i) queue.drop();
  const std::size_t of_eight = queue.begin() + 1;
  ASSERT_EQ(queue[of_eight], 8);
  for (int i = 10; i < 60; ++i) queue.push(i);
  EXPECT_EQ(queue[of_eight], 8);
  for (int i = 7; i < 60; ++i) EXPECT_EQ(queue.pop(), i);
  EXPECT_TRUE(queue.empty());
}

TEST(LongQueue, AnItemThatIsPutInMovesThoseBehindItBack) {
  LongQueue<int> queue;
  for (int i = 0; i < 16; ++i) queue.push(i);
  queue.insert(queue.begin() + 3, 100);  // there is no place for it but by growing
  queue.insert(queue.end(), 101);
  for (const int expected : {0, 1, 2, 100, 3, 4}) EXPECT_EQ(queue.pop(), expected);
  EXPECT_EQ(queue.size(), 12u);
  EXPECT_EQ(queue[queue.end() - 1], 101);
}

TEST(PassTree, IsReadyWhenTheFirstOfAllLeavesIs) {
  PassTree tree(3);
  EXPECT_EQ(tree.ready(), kNoCycle);
  tree.push(2, {40, 1, 2});
  EXPECT_EQ(tree.ready(), 40u);
  tree.push(0, {30, 2, 0, Arrival::Kind::kOverflowed});
  EXPECT_EQ(tree.ready(), 30u);
  EXPECT_EQ(tree.pop(30).ray, 2u);
  EXPECT_EQ(tree.ready(), 40u);
  EXPECT_EQ(tree.pop(40).ray, 1u);
  EXPECT_EQ(tree.ready(), kNoCycle);
}

// Processors 0 and 1 are on one side of the root of four, 2 on the other: it has every other turn.
TEST(PassTree, TakesFromBothSidesInTurns) {
  PassTree tree(4);
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint8_t processor = 0; processor < 3; ++processor) tree.push(processor, {10, processor, 0});
  }
  std::vector<std::uint32_t> order;
  for (int i = 0; i < 8; ++i) order.push_back(tree.pop(10).ray);
  EXPECT_EQ(order, (std::vector<std::uint32_t>{0, 2, 1, 2, 0, 2, 1, 2}));
}

TEST(PassTree, ALaterRayWaitsForNoTurn) {
  PassTree tree(2);
  tree.push(0, {50, 0, 0});
  tree.push(1, {20, 1, 1});
  tree.push(1, {21, 2, 1});
  EXPECT_EQ(tree.pop(20).ray, 1u);
  EXPECT_EQ(tree.pop(21).ray, 2u);
  EXPECT_EQ(tree.pop(50).ray, 0u);
}

}  // namespace
}  // namespace gicube::emu
