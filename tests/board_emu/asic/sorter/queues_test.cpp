// Queues: order, slots and importance.
#include "asic/sorter/queues.h"

#include "test.h"

namespace gicube::emu {
namespace {

RayToken token(std::uint32_t ray, std::uint16_t contribution = 4095) {
  return {.ray = ray, .contribution = contribution};
}

TEST(Queues, GiveRaysInTheOrderOfTheirComing) {
  Queues queues(2, 8, v1::most_rays);
  for (const std::uint32_t ray : {5u, 6u, 7u}) queues.write(0, token(ray));
  queues.write(1, token(9));
  EXPECT_EQ(queues.read(0).ray, 5u);
  EXPECT_EQ(queues.read(1).ray, 9u);
  EXPECT_EQ(queues.read(0).ray, 6u);
  EXPECT_EQ(queues.read(0).ray, 7u);
  EXPECT_EQ(queues.waiting(), 0u);
}

TEST(Queues, KeepASlotUntilItIsReleased) {
  Queues queues(1, 2, v1::most_rays);
  queues.write(0, token(1));
  EXPECT_TRUE(queues.has_slot(0));
  queues.write(0, token(2));
  EXPECT_FALSE(queues.has_slot(0));
  RayToken ray = queues.read(0);
  EXPECT_FALSE(queues.has_slot(0));  // in the pipeline
  ray.has_reserved_slot = true;
  queues.write(0, ray);  // and back
  EXPECT_EQ(queues.slots_taken(0), 2u);
  queues.read(0);
  queues.release_slot(0);
  EXPECT_TRUE(queues.has_slot(0));
  EXPECT_EQ(queues.slots_taken(0), 1u);
}

TEST(Queues, CountRaysOrContributionsAsImportance) {
  Queues by_rays(1, 8, v1::most_rays), by_contribution(1, 8, v1::most_contribution);
  for (Queues* queues : {&by_rays, &by_contribution}) {
    queues->write(0, token(1, 100));
    queues->write(0, token(2, 0));  // counts as 1: a queue with a ray is never unimportant
    queues->write(0, token(3, 4095));
  }
  EXPECT_EQ(by_rays.importance(0), 3u);
  EXPECT_EQ(by_contribution.importance(0), 100u + 1 + 4095);
  by_rays.read(0);
  by_contribution.read(0);
  EXPECT_EQ(by_rays.importance(0), 2u);
  EXPECT_EQ(by_contribution.importance(0), 1u + 4095);
}

TEST(Queues, AreTheMoreImportantTheLongerTheirFirstRayWaits) {
  Queues queues(3, 8, v1::longest_wait);
  queues.write(2, token(1));
  queues.write(0, token(2));
  queues.write(2, token(3));
  queues.write(1, token(4));
  EXPECT_GT(queues.importance(2), queues.importance(0));
  EXPECT_GT(queues.importance(0), queues.importance(1));
  const std::uint32_t before = queues.importance(1);
  queues.write(1, token(5));
  EXPECT_EQ(queues.importance(1), before) << "its first ray came as long ago as before";
  queues.read(2), queues.read(2);
  EXPECT_EQ(queues.importance(2), 0u);
  queues.write(2, token(6));
  EXPECT_LT(queues.importance(2), queues.importance(1)) << "it was empty, and waits since now";
}

TEST(Queues, HaveAnImportanceBelowTheActiveOnesWhateverThePolicy) {
  const auto& policies = *v1::QueuePolicy_descriptor();
  for (int i = 0; i < policies.value_count(); ++i) {
    if (policies.value(i)->number() == 0) continue;
    const ImportanceOf importance = importance_of(static_cast<v1::QueuePolicy>(policies.value(i)->number()));
    for (const std::uint32_t opened : {0u, 1u, ~0u}) {
      for (const std::uint64_t contribution : {std::uint64_t{1}, ~std::uint64_t{0}}) {
        const std::uint32_t got = importance({.waiting = 1, .opened = opened, .contribution = contribution});
        EXPECT_GE(got, 1u) << policies.value(i)->name();
        EXPECT_LE(got, kMaxImportance) << policies.value(i)->name();
      }
    }
  }
  EXPECT_THROW(importance_of(v1::POLICY_UNSPECIFIED), std::invalid_argument);
}

TEST(Queues, CountUpToTheGreatestImportance) {
  const ImportanceOf contribution = importance_of(v1::most_contribution), wait = importance_of(v1::longest_wait);
  EXPECT_EQ(contribution({.waiting = 1, .contribution = 0xFFFF'FFFD}), 0xFFFF'FFFDu);
  EXPECT_EQ(contribution({.waiting = 1, .contribution = 0x1'0000'0000}), 0xFFFF'FFFEu);
  EXPECT_EQ(wait({.waiting = 1, .opened = 5}), 0xFFFF'FFF9u);
  EXPECT_EQ(wait({.waiting = 1, .opened = 0xFFFF'FFFC}), 2u);
  EXPECT_EQ(wait({.waiting = 1, .opened = 0xFFFF'FFFF}), 1u);
}

TEST(Queues, HoldWhatPlainListsHoldUnderRandomUse) {
  constexpr std::uint32_t kQueues = 7, kCapacity = 9;
  Queues queues(kQueues, kCapacity, v1::most_contribution);
  std::vector<std::deque<RayToken>> lists(kQueues);
  std::mt19937 random(3);
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    const auto queue = static_cast<std::uint32_t>(random() % kQueues);
    std::deque<RayToken>& list = lists[queue];
    ASSERT_EQ(queues.has_slot(queue), list.size() < kCapacity);
    if (random() % 2 == 0 && queues.has_slot(queue)) {
      list.push_back(token(i, static_cast<std::uint16_t>(random() % 4096)));
      queues.write(queue, list.back());
    } else if (!list.empty()) {
      ASSERT_EQ(queues.read(queue).ray, list.front().ray);
      queues.release_slot(queue);
      list.pop_front();
    }
    std::uint32_t sum = 0;
    for (const RayToken& ray : list) sum += std::max<std::uint32_t>(1, ray.contribution);
    ASSERT_EQ(queues.importance(queue), sum);
    ASSERT_EQ(queues.waiting(queue), list.size());
  }
}

}  // namespace
}  // namespace gicube::emu
