// The insertion sorter against the plain machine of Figure 7, a plain sort, and hand-worked cycles.
#include "asic/sorter/insertion_sorter.h"

#include "rank_model.h"
#include "test.h"

namespace gicube::emu {
namespace {

using Item = InsertionSorter::Item;
constexpr Item kHole{};
constexpr auto kInfinite = InsertionSorter::kInfinite;

// Inserts and lets the sorter settle.
void settle(InsertionSorter& sorter, const std::vector<Item>& items) {
  for (const Item& item : items) {
    sorter.insert(item.queue, item.importance);
    sorter.step();
  }
  while (sorter.moving()) sorter.step();
}

std::vector<Item> ranks(const InsertionSorter& sorter, std::uint32_t count) {
  std::vector<Item> items;
  for (std::uint32_t rank = 0; rank < count; ++rank) items.push_back(sorter.selected(rank));
  return items;
}

TEST(InsertionSorter, PutsTheFirstItemIntoTheTopRankInOneCycle) {
  InsertionSorter sorter(4);
  EXPECT_EQ(sorter.top(), InsertionSorter::kNoQueue);
  sorter.insert(2, 10);
  EXPECT_EQ(sorter.top(), InsertionSorter::kNoQueue);
  sorter.step();
  EXPECT_EQ(sorter.top(), 2u);
  EXPECT_FALSE(sorter.moving());
}

TEST(InsertionSorter, MovesAnItemOneRankACycle) {
  InsertionSorter sorter(8);
  settle(sorter, {{0, 90}, {1, 80}, {2, 70}, {3, 60}, {4, 50}});
  sorter.insert(5, 55);
  for (std::uint32_t rank = 0; rank <= 4; ++rank) {
    EXPECT_EQ(sorter.comparison(rank), (Item{5, 55})) << rank;
    sorter.step();
  }
  EXPECT_EQ(sorter.selected(4), (Item{5, 55}));  // five cycles after its insertion
  EXPECT_EQ(sorter.comparison(5), (Item{4, 50}));
  sorter.step();
  EXPECT_EQ(sorter.selected(5), (Item{4, 50}));
  EXPECT_FALSE(sorter.moving());
}

TEST(InsertionSorter, WipesTheOldPlaceAtTheMomentOfInsertion) {
  InsertionSorter sorter(4);
  settle(sorter, {{0, 30}, {1, 20}, {2, 10}});
  sorter.insert(1, 25);
  EXPECT_EQ(ranks(sorter, 3), (std::vector<Item>{{0, 30}, kHole, {2, 10}}));
  sorter.step();
  EXPECT_EQ(sorter.comparison(1), (Item{1, 25}));
  sorter.insert(1, 35);  // now in a comparison buffer
  EXPECT_EQ(sorter.comparison(1), kHole);
  sorter.step();
  sorter.step();
  EXPECT_EQ(ranks(sorter, 3), (std::vector<Item>{{1, 35}, {0, 30}, {2, 10}}));
  EXPECT_EQ(sorter.size(), 3u);
}

TEST(InsertionSorter, FillsAHoleWithTheFirstItemThatComesDown) {
  InsertionSorter sorter(4);
  settle(sorter, {{0, 30}, {1, 20}, {2, 10}});
  sorter.insert(3, 5);
  sorter.step();
  sorter.insert(1, 40);  // wipes rank 1 in front of queue 3
  sorter.step();
  EXPECT_EQ(ranks(sorter, 3), (std::vector<Item>{{1, 40}, {3, 5}, {2, 10}}));  // for one cycle out of order
  sorter.step();
  EXPECT_EQ(ranks(sorter, 3), (std::vector<Item>{{1, 40}, {0, 30}, {2, 10}}));
  sorter.step();
  sorter.step();
  EXPECT_EQ(ranks(sorter, 4), (std::vector<Item>{{1, 40}, {0, 30}, {2, 10}, {3, 5}}));
}

TEST(InsertionSorter, KeepsTheActiveQueueAtTheTopWhateverComes) {
  InsertionSorter sorter(3);
  settle(sorter, {{0, 1}});
  sorter.activate_top();
  settle(sorter, {{1, 1000}, {2, kInfinite - 1}});
  EXPECT_EQ(ranks(sorter, 3), (std::vector<Item>{{0, kInfinite}, {2, kInfinite - 1}, {1, 1000}}));
}

TEST(InsertionSorter, MovesBothBuffersOfAllRanksUpAtOnce) {
  InsertionSorter sorter(4);
  settle(sorter, {{0, 30}, {1, 20}, {2, 10}});
  sorter.activate_top();
  sorter.insert(3, 15);
  sorter.step();
  sorter.step();
  ASSERT_EQ(sorter.comparison(2), (Item{3, 15}));
  sorter.shift_up();
  EXPECT_EQ(ranks(sorter, 3), (std::vector<Item>{{1, 20}, {2, 10}, kHole}));
  EXPECT_EQ(sorter.comparison(1), (Item{3, 15}));
  EXPECT_EQ(sorter.size(), 3u);
}

TEST(InsertionSorter, TakesNoInsertInACycleInWhichShiftUpFilledItsPlace) {
  InsertionSorter sorter(4);
  settle(sorter, {{0, 30}, {1, 20}});
  sorter.activate_top();
  sorter.insert(2, 5);
  sorter.step();
  sorter.shift_up();
  EXPECT_FALSE(sorter.can_insert());
  sorter.step();
  EXPECT_TRUE(sorter.can_insert());
  EXPECT_EQ(sorter.top(), 1u);
}

TEST(InsertionSorter, PutsTheLowerQueueNumberFirstAmongEquals) {
  InsertionSorter sorter(4);
  settle(sorter, {{2, 7}, {3, 7}, {0, 7}, {1, 7}});
  EXPECT_EQ(ranks(sorter, 4), (std::vector<Item>{{0, 7}, {1, 7}, {2, 7}, {3, 7}}));
}

TEST(InsertionSorter, SortsLikeAPlainSortOnceSettled) {
  std::mt19937 random(11);
  for (const std::uint32_t queues : {1u, 2u, 3u, 17u, 128u}) {
    InsertionSorter sorter(queues);
    std::vector<Item> latest(queues);
    for (int change = 0; change < 500; ++change) {  // importance only grows while a queue is not active
      const auto queue = static_cast<std::uint32_t>(random() % queues);
      Item& item = latest[queue];
      item = {queue, item.importance + 1 + static_cast<std::uint32_t>(random() % 20)};
      sorter.insert(item.queue, item.importance);
      for (auto cycles = 1 + random() % 3; cycles > 0; --cycles) sorter.step();
    }
    while (sorter.moving()) sorter.step();
    std::erase(latest, Item{});
    std::sort(latest.begin(), latest.end(), [](const Item& a, const Item& b) {
      return a.importance != b.importance ? a.importance > b.importance : a.queue < b.queue;
    });
    EXPECT_EQ(ranks(sorter, static_cast<std::uint32_t>(latest.size())), latest) << queues << " queues";
  }
}

TEST(InsertionSorter, SettlesWithinOneCycleARank) {
  constexpr std::uint32_t kQueues = 64;
  InsertionSorter sorter(kQueues);
  for (std::uint32_t queue = 0; queue < kQueues; ++queue) {
    sorter.insert(queue, 1 + queue);  // each goes to the top and pushes all others down
    sorter.step();
  }
  std::uint32_t cycles = 0;
  for (; sorter.moving(); ++cycles) sorter.step();
  EXPECT_EQ(cycles, kQueues - 1);
}

// Random inserts (any importance, up or down), activations and shifts; all buffers of both after every cycle.
void compare_with_the_model(std::uint32_t queues, unsigned seed) {
  InsertionSorter sorter(queues);
  RankModel model(queues);
  std::mt19937 random(seed);
  bool active = false;
  for (int cycle = 0; cycle < 1500; ++cycle) {
    sorter.step();
    model.step();
    if (!active && sorter.top() != InsertionSorter::kNoQueue && random() % 2 == 0) {
      sorter.activate_top();
      model.activate_top();
      active = true;
    } else if (random() % 8 == 0 && (active || sorter.top() == InsertionSorter::kNoQueue)) {
      sorter.shift_up();
      model.shift_up();
      active = false;
    }
    ASSERT_EQ(sorter.can_insert(), model.can_insert());
    const auto queue = static_cast<std::uint32_t>(random() % queues);
    const bool is_active = active && queue == sorter.top();
    if (random() % 4 != 0 && sorter.can_insert() && !is_active) {
      const auto importance = static_cast<std::uint32_t>(1 + random() % 30);
      sorter.insert(queue, importance);
      model.insert(queue, importance);
    }
    for (std::uint32_t rank = 0; rank < queues; ++rank) {
      ASSERT_EQ(sorter.selected(rank), model.selected(rank)) << "cycle " << cycle << " rank " << rank;
      ASSERT_EQ(sorter.comparison(rank), model.comparison(rank)) << "cycle " << cycle << " rank " << rank;
    }
  }
  EXPECT_FALSE(model.lost());
}

TEST(InsertionSorter, HoldsInEveryBufferWhatThePlainMachineHoldsInEveryCycle) {
  unsigned seed = 1;
  for (const std::uint32_t queues : {1u, 2u, 3u, 4u, 5u, 8u, 31u, 64u}) {
    for (int repeat = 0; repeat < 4; ++repeat) {
      compare_with_the_model(queues, seed++);
      if (HasFatalFailure()) return;
    }
  }
}

}  // namespace

void PrintTo(const InsertionSorter::Item& item, std::ostream* out) { *out << item.queue << ':' << item.importance; }

}  // namespace gicube::emu
