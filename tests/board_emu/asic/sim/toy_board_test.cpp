// Sorters, ray bus, ring and merge tree in a closed loop.
#include "toy_board.h"

#include "test.h"

namespace gicube::emu {
namespace {

std::vector<ToyScene> scenes() {
  std::vector<ToyScene> all;
  for (const std::uint32_t processors : {1u, 2u, 3u, 4u, 8u}) {
    for (const std::uint32_t capacity : {1u, 3u, 64u}) {
      ToyScene scene{.processors = processors};
      scene.sorter.capacity = capacity;
      all.push_back(scene);
      scene.sorter.policy = v1::most_contribution;
      scene.runs = true;
      all.push_back(scene);
      scene.sorter.bus_waits = true;
      scene.sorter.ideal_sorter = true;
      all.push_back(scene);
      scene.sorter.single = true;
      scene.link_bits = 16;
      all.push_back(scene);
    }
  }
  return all;
}

std::string name(const ToyScene& scene) {
  std::ostringstream text;
  text << scene.processors << " processors, queues of " << scene.sorter.capacity
       << (scene.sorter.single         ? ", single"
           : scene.sorter.ideal_sorter ? ", ideal sorter"
                                       : "");
  return text.str();
}

TEST(ToyBoard, BringsEveryRayBackOnceWhateverTheConfiguration) {
  std::uint64_t overflows = 0;
  for (const ToyScene& scene : scenes()) {
    ToyBoard board(scene);
    board.run(1'000'000, 0);
    EXPECT_EQ(board.finished(), std::vector<int>(scene.rays, 1)) << name(scene);
    for (std::uint32_t ray = 0; ray < scene.rays; ++ray) ASSERT_EQ(board.hops()[ray], 12 + ray % 7) << name(scene);
    overflows += board.overflows();
  }
  EXPECT_GT(overflows, 1000u);
}

TEST(ToyBoard, LeavesNothingBehind) {
  for (const ToyScene& scene : scenes()) {
    ToyBoard board(scene);
    board.run(1'000'000, 0);
    EXPECT_TRUE(board.idle()) << name(scene);
  }
}

TEST(ToyBoard, DoesTheSameInTheSameCyclesInWhateverOrderItsPartsTick) {
  for (const ToyScene& scene : scenes()) {
    ToyBoard plain(scene), shuffled(scene);
    plain.run(1'000'000, 0);
    shuffled.run(1'000'000, 77);
    EXPECT_EQ(plain.cycles(), shuffled.cycles()) << name(scene);
    for (std::uint32_t i = 0; i < scene.processors; ++i) {
      ASSERT_EQ(plain.processor(i).log, shuffled.processor(i).log) << name(scene) << ", processor " << i;
      const SorterCounters& a = plain.processor(i).sorter().counters();
      const SorterCounters& b = shuffled.processor(i).sorter().counters();
      EXPECT_EQ(a.conflicts, b.conflicts) << name(scene);
      EXPECT_EQ(a.activation_rays, b.activation_rays) << name(scene);
    }
  }
}

}  // namespace
}  // namespace gicube::emu
