// The registered FIFO: nothing that happens in a cycle is seen before the edge that ends it.
#include "asic/sim/fifo.h"

#include "test.h"

namespace gicube::emu {
namespace {

TEST(Fifo, ShowsAPushedItemOneCycleLater) {
  Fifo<int> fifo(2);
  fifo.push(0, 7);
  EXPECT_FALSE(fifo.can_pop(0));
  EXPECT_FALSE(fifo.empty());
  ASSERT_TRUE(fifo.can_pop(1));
  EXPECT_EQ(fifo.front(), 7);
  fifo.push(1, 8);
  EXPECT_EQ(fifo.back(), 8);
  EXPECT_EQ(fifo.pop(1), 7);
  EXPECT_EQ(fifo.pop(2), 8);
  EXPECT_TRUE(fifo.empty());
}

TEST(Fifo, TakesOneItemACycleAndGivesOne) {
  Fifo<int> fifo(4);
  fifo.push(0, 1);
  EXPECT_FALSE(fifo.can_push(0));
  fifo.push(1, 2);
  EXPECT_EQ(fifo.pop(2), 1);
  EXPECT_FALSE(fifo.can_pop(2));
  EXPECT_TRUE(fifo.can_pop(3));
}

TEST(Fifo, HidesAFreedPlaceUntilTheNextCycle) {
  Fifo<int> fifo(1);
  fifo.push(0, 1);
  EXPECT_FALSE(fifo.can_push(1));
  EXPECT_EQ(fifo.pop(1), 1);
  EXPECT_FALSE(fifo.can_push(1));
  EXPECT_EQ(fifo.room(1), 0u);
  EXPECT_TRUE(fifo.can_push(2));
  EXPECT_EQ(fifo.room(2), 1u);
}

// Items passed in 100 cycles by a producer and a consumer that do all they can.
int passed_in_100_cycles(std::size_t capacity) {
  Fifo<int> fifo(capacity);
  int passed = 0;
  for (Cycle now = 0; now < 100; ++now) {
    if (fifo.can_pop(now)) passed += fifo.pop(now);
    if (fifo.can_push(now)) fifo.push(now, 1);
  }
  return passed;
}

TEST(Fifo, KeepsFullRateWithTwoPlacesAndHalvesItWithOne) {
  EXPECT_EQ(passed_in_100_cycles(2), 99);
  EXPECT_EQ(passed_in_100_cycles(1), 50);
}

// Pops and pushes at random times; the order of consumer and producer within a cycle is `consumer_first`'s.
std::vector<int> run(std::size_t capacity, bool shuffled) {
  Fifo<int> fifo(capacity);
  std::mt19937 wishes(5), order(6);
  std::vector<int> log;
  int next = 0;
  for (Cycle now = 0; now < 2000; ++now) {
    const bool wants_pop = wishes() % 3 != 0, wants_push = wishes() % 3 != 0;
    const auto pop = [&] { log.push_back(wants_pop && fifo.can_pop(now) ? fifo.pop(now) : -1); };
    const auto push = [&] {
      if (wants_push && fifo.can_push(now)) fifo.push(now, next++);
    };
    if (shuffled && order() % 2 == 0) {
      push();
      pop();
    } else {
      pop();
      push();
    }
  }
  return log;
}

TEST(Fifo, BehavesTheSameInWhateverOrderItsUsersTick) {
  for (const std::size_t capacity : {1u, 2u, 3u, 8u}) EXPECT_EQ(run(capacity, true), run(capacity, false)) << capacity;
}

TEST(Fifo, KeepsTheOrderOfItsItems) {
  int expected = 0;
  for (const int item : run(3, true)) {
    if (item >= 0) {
      EXPECT_EQ(item, expected++);
    }
  }
  EXPECT_GT(expected, 500);
}

}  // namespace
}  // namespace gicube::emu
