// The sorter cycle by cycle: two rays in, one out, slots, overflow, and which queue is active.
#include "asic/sorter/sorter.h"

#include "sorter_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

using Rays = std::vector<std::uint32_t>;

SorterSetup small(std::uint32_t capacity = 8) { return {.queues = 8, .capacity = capacity}; }

TEST(Sorter, IssuesARayTheCycleAfterItWasWritten) {
  SorterRig rig(small());
  rig.bus.push(rig.now, rig.ray(1, 3));
  rig.tick();  // 0: not yet visible
  EXPECT_TRUE(rig.sorter.idle());
  rig.tick();  // 1: written, inserted
  EXPECT_EQ(rig.sorter.waiting(), 1u);
  EXPECT_FALSE(rig.sorter.has_active());
  rig.tick();  // 2: chosen, issued, given up
  EXPECT_TRUE(rig.sorter.idle());
  EXPECT_FALSE(rig.sorter.has_active());
  ASSERT_TRUE(rig.issue.can_pop(3));
  EXPECT_EQ(rig.issue.pop(3).queue, 3u);
  EXPECT_EQ(rig.sorter.counters().activations, 1u);
}

TEST(Sorter, WritesTwoRaysACycleAndTheReturnedOneFirst) {
  SorterRig rig(small());
  rig.returned.push(0, rig.ray(1, 1));
  rig.bus.push(0, rig.ray(2, 2));
  rig.left.push(0, rig.ray(3, 3));
  rig.right.push(0, rig.ray(4, 4));
  rig.tick(2);
  EXPECT_TRUE(rig.returned.empty());
  EXPECT_TRUE(rig.bus.empty());
  EXPECT_FALSE(rig.left.empty());
  EXPECT_EQ(rig.sorter.counters().written, 2u);
  rig.tick();
  EXPECT_TRUE(rig.left.empty());
  EXPECT_TRUE(rig.right.empty());
  EXPECT_EQ(rig.sorter.counters().written, 4u);
}

TEST(Sorter, GivesBusLeftAndRightTheirTurns) {
  SorterRig rig(small(64));
  for (std::uint32_t i = 0; i < 12; ++i) {
    rig.returned.push(i, rig.ray(i, 1));
    rig.bus.push(i, rig.ray(100 + i, 2));
    rig.left.push(i, rig.ray(200 + i, 3));
    rig.right.push(i, rig.ray(300 + i, 4));
  }
  rig.now = 12;
  rig.tick(9);  // each returned one takes one of two turns
  EXPECT_EQ(rig.returned.size(), 3u);
  EXPECT_EQ(rig.bus.size(), 9u);
  EXPECT_EQ(rig.left.size(), 9u);
  EXPECT_EQ(rig.right.size(), 9u);
}

TEST(Sorter, LetsTheSecondOfTwoRaysForOneQueueWait) {
  SorterRig rig(small());
  rig.returned.push(0, rig.ray(1, 5));
  rig.bus.push(0, rig.ray(2, 5));
  rig.left.push(0, rig.ray(3, 6));
  rig.tick(2);
  EXPECT_EQ(rig.sorter.counters().conflicts, 1u);
  EXPECT_EQ(rig.sorter.counters().written, 1u);  // the lost turn goes to nobody
  EXPECT_EQ(rig.left.size(), 1u);
  rig.tick();
  EXPECT_EQ(rig.sorter.counters().conflicts, 1u);
  EXPECT_EQ(rig.sorter.counters().written, 3u);
}

TEST(Sorter, SendsARayWithoutSlotToOverflow) {
  SorterRig rig(small(2));
  for (std::uint32_t i = 0; i < 4; ++i) rig.bus.push(i, rig.ray(i, 0));
  rig.issue.push(0, {});  // the pipeline stalls: fill the FIFO
  for (Cycle c = 1; c < 64; ++c) rig.issue.push(c, {});
  rig.now = 64;
  rig.tick(4);
  EXPECT_EQ(rig.sorter.waiting(0), 2u);
  EXPECT_EQ(rig.sorter.counters().overflows, 2u);
  ASSERT_TRUE(rig.overflow.can_pop(rig.now));
  EXPECT_EQ(rig.overflow.front().state, TokenStatus::kOverflowed);
  EXPECT_EQ(rig.overflowed(), (Rays{2, 3}));
}

TEST(Sorter, CountsARayInThePipelineAsHolderOfItsSlot) {
  SorterRig rig(small(1));
  rig.bus.push(0, rig.ray(1, 0));
  rig.tick(3);
  ASSERT_EQ(rig.issued(), Rays{1});
  rig.bus.push(rig.now, rig.ray(2, 0));
  rig.tick(2);
  EXPECT_EQ(rig.overflowed(), Rays{2});
  RayToken back = rig.ray(1, 0);
  back.has_reserved_slot = true;
  rig.returned.push(rig.now, back);
  rig.tick(3);
  EXPECT_EQ(rig.issued(), Rays{1});
  EXPECT_EQ(rig.sorter.counters().overflows, 1u);
}

TEST(Sorter, GivesAReleasedSlotToARayOfTheSameCycle) {
  SorterRig rig(small(1));
  rig.bus.push(0, rig.ray(1, 0));
  rig.tick(3);
  ASSERT_EQ(rig.issued(), Rays{1});
  rig.released.push(rig.now, 0);
  rig.bus.push(rig.now, rig.ray(2, 0));
  rig.tick(3);
  EXPECT_EQ(rig.issued(), Rays{2});
  EXPECT_EQ(rig.sorter.counters().overflows, 0u);
}

TEST(Sorter, LetsARayThatComesBackToAnotherQueueOverflow) {
  SorterRig rig(small(1));
  rig.bus.push(0, rig.ray(1, 0));
  rig.bus.push(1, rig.ray(2, 1));
  rig.tick(5);
  ASSERT_EQ(rig.issued(), (Rays{1, 2}));
  rig.returned.push(rig.now, rig.ray(1, 1));  // its new queue's slot is ray 2's, which is in the pipeline
  rig.tick(2);
  EXPECT_EQ(rig.overflowed(), Rays{1});
}

TEST(Sorter, PassesOverAnInputWhoseRayFindsNeitherSlotNorOverflow) {
  SorterRig rig(small(1), 1);
  rig.issue.push(0, {});
  rig.overflow.push(0, {});
  rig.bus.push(0, rig.ray(1, 0));
  rig.bus.push(1, rig.ray(2, 0));  // no slot
  rig.left.push(2, rig.ray(3, 1));
  rig.tick(5);
  EXPECT_EQ(rig.bus.size(), 1u);
  EXPECT_TRUE(rig.left.empty());
  rig.overflow.pop(5);
  rig.now = 6;
  rig.tick();
  EXPECT_TRUE(rig.bus.empty());
  EXPECT_EQ(rig.sorter.counters().overflows, 1u);
}

TEST(Sorter, LetsRaysFromTheBusWaitForASlotIfToldSo) {
  SorterSetup setup = small(1);
  setup.bus_waits = true;
  SorterRig rig(setup);
  rig.bus.push(0, rig.ray(1, 0));
  rig.bus.push(1, rig.ray(2, 0));
  rig.left.push(2, rig.ray(3, 0));
  rig.tick(6);
  EXPECT_EQ(rig.bus.size(), 1u);
  EXPECT_EQ(rig.overflowed(), Rays{3});  // links never wait
  rig.released.push(rig.now, 0);
  rig.tick(3);
  EXPECT_EQ(rig.issued(), (Rays{1, 2}));
}

TEST(Sorter, StaysWithTheActiveQueueUntilItIsEmpty) {
  SorterRig rig(small());
  for (std::uint32_t i = 0; i < 3; ++i) rig.bus.push(i, rig.ray(i, 0));
  for (std::uint32_t i = 0; i < 6; ++i) rig.left.push(i, rig.ray(10 + i, 1));  // soon the more important one
  rig.now = 6;
  rig.tick(2);
  EXPECT_EQ(rig.sorter.active(), 0u);
  rig.tick(12);
  EXPECT_EQ(rig.issued(), (Rays{0, 1, 2, 10, 11, 12, 13, 14, 15}));
  EXPECT_EQ(rig.sorter.counters().activations, 2u);
  EXPECT_EQ(rig.sorter.counters().activation_rays[1], 1u);  // three rays
  EXPECT_EQ(rig.sorter.counters().activation_rays[2], 1u);  // six
  EXPECT_EQ(rig.sorter.counters().activation_issued[1], 3u);
  EXPECT_EQ(rig.sorter.counters().activation_issued[2], 6u);
}

TEST(Sorter, GoesFromOneQueueToTheNextWithoutALostCycle) {
  SorterRig rig(small());
  for (std::uint32_t i = 0; i < 4; ++i) {
    rig.bus.push(i, rig.ray(i, 0));
    rig.left.push(i, rig.ray(10 + i, 1));
  }
  rig.now = 4;
  for (Cycle cycle = 0; cycle < 9; ++cycle) {
    rig.tick();
    EXPECT_EQ(rig.sorter.counters().issued, cycle);  // first written, then one a cycle
  }
  EXPECT_EQ(rig.sorter.counters().activations, 2u);
}

TEST(Sorter, GivesAnEmptiedQueueUpAndInsertsItAnewWhenARayReturns) {
  SorterRig rig(small());
  rig.bus.push(0, rig.ray(1, 0));
  rig.tick(3);
  EXPECT_FALSE(rig.sorter.has_active());
  RayToken back = rig.ray(1, 0);
  back.has_reserved_slot = true;
  rig.returned.push(rig.now, back);
  rig.tick(3);
  EXPECT_EQ(rig.sorter.counters().activations, 2u);
  EXPECT_EQ(rig.sorter.counters().inserts, 2u);
}

TEST(Sorter, InsertsNothingForTheActiveQueue) {
  SorterRig rig(small(64));
  for (std::uint32_t i = 0; i < 40; ++i) rig.bus.push(i, rig.ray(i, 0));
  rig.now = 40;
  rig.tick(45);
  EXPECT_EQ(rig.sorter.counters().issued, 40u);
  EXPECT_EQ(rig.sorter.counters().inserts, 1u);
}

// Queue 7 is active with rays enough, while queues 0 to 2 get rays that the two policies weigh differently.
Rays order_of_queues(v1::QueuePolicy policy, bool ideal) {
  SorterSetup setup{.queues = 8, .capacity = 64, .policy = policy, .ideal_sorter = ideal};
  SorterRig rig(setup);
  for (std::uint32_t i = 0; i < 20; ++i) rig.bus.push(i, rig.ray(700 + i, 7));
  rig.now = 20;
  rig.tick(2);
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t queue = i < 3 ? 0 : i < 5 ? 1 : 2;
    const std::uint16_t contribution = queue == 0 ? 10 : queue == 1 ? 2000 : 3000;
    rig.left.push(rig.now, rig.ray(100 * queue + i, queue, contribution));
    rig.tick();
  }
  rig.tick(40);
  Rays rest = rig.issued();
  rest.erase(rest.begin(), rest.begin() + 20);
  return rest;
}

TEST(Sorter, TakesTheQueueThatItsPolicyFindsMostImportant) {
  for (const bool ideal : {false, true}) {
    EXPECT_EQ(order_of_queues(v1::most_rays, ideal), (Rays{0, 1, 2, 103, 104, 205}));
    EXPECT_EQ(order_of_queues(v1::most_contribution, ideal), (Rays{103, 104, 205, 0, 1, 2}));
    EXPECT_EQ(order_of_queues(v1::longest_wait, ideal), (Rays{0, 1, 2, 103, 104, 205}));
  }
}

// Queue 0 gives its last ray in cycle 9, in which first queue 6 and then queue 5 gets a ray. Only one of the two can be
// inserted before the next queue is chosen.
std::uint32_t chosen_after_a_late_ray(bool ideal) {
  SorterSetup setup = small();
  setup.ideal_sorter = ideal;
  SorterRig rig(setup);
  for (const std::uint32_t queue : {0u, 0u, 0u, 0u, 6u}) rig.bus.push(rig.now++, rig.ray(0, queue));
  rig.now = 0;
  for (const std::uint32_t queue : {4u, 4u, 5u, 5u, 5u}) rig.left.push(rig.now++, rig.ray(0, queue));
  rig.tick(5);  // 5 .. 9
  EXPECT_EQ(rig.sorter.counters().issued, 4u);
  EXPECT_FALSE(rig.sorter.has_active());
  EXPECT_EQ(rig.sorter.waiting(5), 3u);
  rig.tick();
  return rig.sorter.active();
}

TEST(Sorter, KnowsTheMostImportantQueueOnlyAfterItHasBeenSortedInUnlessItIsIdeal) {
  EXPECT_EQ(chosen_after_a_late_ray(true), 5u);
  EXPECT_EQ(chosen_after_a_late_ray(false), 4u);
}

TEST(Sorter, NeverOverflowsWithIdealQueues) {
  SorterSetup setup = small(1);
  setup.ideal_queues = true;
  SorterRig rig(setup);
  for (std::uint32_t i = 0; i < 60; ++i) rig.bus.push(i, rig.ray(i, 0));
  rig.now = 60;
  rig.tick(70);
  EXPECT_EQ(rig.sorter.counters().issued, 60u);
  EXPECT_EQ(rig.sorter.counters().overflows, 0u);
}

TEST(Sorter, KeepsTheOrderOfComingWithASingleQueue) {
  SorterSetup setup = small(3);
  setup.single = true;
  SorterRig rig(setup);
  for (std::uint32_t i = 0; i < 4; ++i) rig.bus.push(i, rig.ray(i, 1000 + i % 2));  // numbers of blocks
  rig.now = 4;
  rig.tick(6);
  EXPECT_EQ(rig.sorter.counters().overflows, 1u);  // three slots in all
  ASSERT_TRUE(rig.issue.can_pop(rig.now));
  EXPECT_EQ(rig.issue.front().queue, 1000u);
  EXPECT_EQ(rig.issued(), (Rays{0, 1, 2}));
  rig.released.push(rig.now, 1001);  // a slot, for the ray that has overflowed
  RayToken again = rig.ray(3, 1001);
  again.has_reserved_slot = true;
  rig.bus.push(rig.now, again);
  rig.tick(3);
  EXPECT_EQ(rig.issued(), Rays{3});
  EXPECT_EQ(rig.sorter.counters().inserts, 0u);
}

TEST(Sorter, TakesNoStorageForRaysThatAreNotThere) {
  SorterRig rig({.queues = 100'000, .capacity = 4096});  // 6 GB if queues were arrays
  rig.bus.push(0, rig.ray(1, 99'999));
  rig.tick(3);
  EXPECT_EQ(rig.issued(), Rays{1});
}

TEST(Sorter, DoesNothingWhileNothingComes) {
  SorterRig rig(small());
  EXPECT_FALSE(rig.sorter.tick(0));
  rig.bus.push(1, rig.ray(1, 0));
  EXPECT_TRUE(rig.sorter.tick(2));
  EXPECT_TRUE(rig.sorter.tick(3));
  EXPECT_FALSE(rig.sorter.tick(4));
}

// With a pipeline that takes no ray: two rays are written in cycle 1, the second's queue is inserted in cycle 2. Queue
// 1 is active.
TEST(Sorter, MovesInTheCyclesInWhichARayIsWrittenOrAQueueInserted) {
  SorterRig rig(small(), 1);
  rig.issue.push(0, {});
  rig.bus.push(0, rig.ray(1, 1));
  rig.left.push(0, rig.ray(2, 2));
  EXPECT_TRUE(rig.sorter.tick(1));
  EXPECT_EQ(rig.sorter.counters().written, 2u);
  EXPECT_TRUE(rig.sorter.tick(2));
  EXPECT_EQ(rig.sorter.counters().inserts, 2u);
  EXPECT_EQ(rig.sorter.active(), 1u);
  EXPECT_FALSE(rig.sorter.tick(3));
  rig.bus.push(3, rig.ray(3, 1));
  EXPECT_TRUE(rig.sorter.tick(4)) << "a ray for the active queue";
  EXPECT_EQ(rig.sorter.counters().inserts, 2u);
  EXPECT_FALSE(rig.sorter.tick(5));
}

TEST(Sorter, DescribesWhereRaysStand) {
  SorterRig rig(small());
  for (std::uint32_t i = 0; i < 3; ++i) rig.bus.push(i, rig.ray(i, 4));
  rig.now = 3;
  rig.tick(2);
  std::ostringstream text;
  rig.sorter.dump(text);
  EXPECT_NE(text.str().find("queue 4 is active with 1 rays waiting and 2 slots taken"), std::string::npos)
      << text.str();
}

}  // namespace
}  // namespace gicube::emu
