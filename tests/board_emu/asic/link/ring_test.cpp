// The ring of neighbour links: time on a link, ways round, bubbles, back-pressure.
#include "asic/link/ring.h"

#include "test.h"

namespace gicube::emu {
namespace {

struct RingRig {
  RingRig(std::size_t processors, std::uint32_t bits, std::uint32_t rays = 4, std::size_t places = 4)
      : out(processors, Fifo<RayToken>(places)), left(out), right(out) {
    std::vector<Ring::Port> ports;
    for (std::size_t i = 0; i < processors; ++i) ports.push_back({&out[i], &left[i], &right[i]});
    ring = std::make_unique<Ring>(bits, rays, ports);
  }
  void send(std::size_t from, std::uint8_t to, std::uint32_t id = 0) {
    out[from].push(now, {.ray = id, .processor = to});
  }
  void tick(int cycles = 1) {
    while (cycles-- > 0) ring->tick(now++);
  }

  Cycle now = 0;
  std::vector<Fifo<RayToken>> out, left, right;
  std::unique_ptr<Ring> ring;
};

// Cycles from the sender's FIFO to the receiver's; `from_left` tells by which of its two.
Cycle travel(RingRig& rig, std::size_t from, std::uint8_t to, bool from_left) {
  rig.send(from, to);
  Fifo<RayToken>& end = (from_left ? rig.left : rig.right)[to];
  const Cycle begin = rig.now + 1;
  while (!end.can_pop(rig.now) && rig.now < begin + 10'000) rig.tick();
  EXPECT_TRUE(rig.ring->idle());
  if (!end.can_pop(rig.now)) return kNoCycle;
  end.pop(rig.now);
  return rig.now - begin;
}

TEST(Ring, TakesOneCycleToEnterAndAsManyALinkAsTheRayHasParts) {
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> cycles_by_bits{
      {256, 1}, {128, 2}, {64, 4}, {32, 8}, {16, 16}, {8, 32}, {4, 64}, {2, 128}, {1, 256}, {100, 3}};
  for (const auto& [bits, cycles] : cycles_by_bits) {
    RingRig rig(4, bits);
    EXPECT_EQ(rig.ring->cycles_per_ray(), cycles);
    EXPECT_EQ(travel(rig, 0, 1, true), 1 + cycles) << bits;
    EXPECT_EQ(rig.ring->counters(0).busy, cycles);
  }
}

TEST(Ring, TakesTheShorterWayAndTheRightOneIfBothAreAsLong) {
  RingRig rig(8, 64);
  EXPECT_EQ(travel(rig, 6, 1, true), 1u + 3 * 4);   // right over 7 and 0
  EXPECT_EQ(travel(rig, 1, 6, false), 1u + 3 * 4);  // left over 0 and 7
  EXPECT_EQ(travel(rig, 2, 6, true), 1u + 4 * 4);   // as far either way
  EXPECT_EQ(rig.ring->counters(6).rays[0], 1u);
  EXPECT_EQ(rig.ring->counters(7).hops(), 2u);  // one each way
  EXPECT_EQ(rig.ring->counters(7).sent, 0u);
}

TEST(Ring, UsesOnlyTheRightLinksOfTwoProcessors) {
  RingRig rig(2, 256);
  EXPECT_EQ(travel(rig, 0, 1, true), 2u);
  EXPECT_EQ(travel(rig, 1, 0, true), 2u);
  EXPECT_EQ(rig.ring->counters(0).rays[1] + rig.ring->counters(1).rays[1], 0u);
}

TEST(Ring, HasNoLinksWithOneProcessor) {
  RingRig rig(1, 32);
  EXPECT_FALSE(rig.ring->tick(0));
  EXPECT_TRUE(rig.ring->idle());
  EXPECT_EQ(rig.ring->bisection_rays(), 0u);
}

TEST(Ring, PassesOneRayALinkInEachOfItsPeriods) {
  RingRig rig(4, 64, 4, 64);
  for (std::uint32_t i = 0; i < 20; ++i) {
    rig.send(0, 1, i);
    ++rig.now;
  }
  rig.tick(1 + 10 * 4);
  EXPECT_EQ(rig.ring->counters(0).rays[0], 10u);
  for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(rig.left[1].pop(rig.now++).ray, i);
}

TEST(Ring, HoldsTheLinkWhileTheReceiverHasNoRoom) {
  RingRig rig(4, 128, 4, 1);
  rig.send(0, 1, 1);
  rig.tick(2);
  rig.send(0, 1, 2);
  rig.tick(8);  // ray 1 arrives in cycle 3; ray 2 is through by cycle 5
  EXPECT_EQ(rig.ring->counters(0).rays[0], 1u);
  EXPECT_EQ(rig.ring->counters(0).blocked, 5u);
  rig.left[1].pop(rig.now);
  rig.tick(2);
  EXPECT_EQ(rig.ring->counters(0).rays[0], 2u);
}

TEST(Ring, LetsARayEnterOnlyIfTwoPlacesAreFree) {
  RingRig rig(4, 1, 3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    rig.send(0, 1, i);
    rig.tick();
  }
  rig.tick(10);
  EXPECT_EQ(rig.ring->counters(0).sent, 2u);  // of three places one stays free for transit
  EXPECT_EQ(rig.out[0].size(), 1u);
  EXPECT_EQ(rig.ring->counters(0).entry_waits, 10u);
}

TEST(Ring, LetsTransitGoBeforeARayThatEnters) {
  RingRig rig(4, 256, 4);
  rig.send(0, 2, 1);
  rig.tick(2);
  rig.send(1, 2, 2);  // visible in cycle 3, one after ray 1 reached link 1: meets nobody
  rig.tick(5);
  EXPECT_EQ(rig.left[2].pop(rig.now++).ray, 1u);
  RingRig same(4, 256, 4);
  same.send(0, 2, 1);
  same.tick();
  same.send(1, 2, 2);  // visible in cycle 2, in which ray 1 moves to link 1
  same.tick(2);
  EXPECT_EQ(same.out[1].size(), 1u);
  EXPECT_EQ(same.ring->counters(1).entry_waits, 1u);
  same.tick(4);
  EXPECT_EQ(same.left[2].pop(same.now++).ray, 1u);
  EXPECT_EQ(same.left[2].pop(same.now++).ray, 2u);
}

TEST(Ring, CountsRaysOverTheBisection) {
  RingRig rig(4, 256);
  travel(rig, 1, 2, true);   // over the cut in the middle
  travel(rig, 0, 1, true);   // over none
  travel(rig, 0, 3, false);  // over the other cut
  travel(rig, 0, 2, true);   // over the one in the middle
  EXPECT_EQ(rig.ring->bisection_rays(), 3u);
}

TEST(Ring, OfTwoProcessorsIsHalvedByEachOfItsLinks) {
  RingRig rig(2, 256);
  travel(rig, 0, 1, true);
  travel(rig, 1, 0, true);
  travel(rig, 1, 0, true);
  EXPECT_EQ(rig.ring->bisection_rays(), 3u);
}

// Pushed in cycle 0, seen in 1; two cycles on the link.
TEST(Ring, MovesInTheCyclesInWhichARayEntersOrIsOnALink) {
  RingRig rig(4, 128);
  rig.send(0, 1);
  EXPECT_FALSE(rig.ring->tick(0));
  for (Cycle now = 1; now <= 3; ++now) EXPECT_TRUE(rig.ring->tick(now)) << now;
  EXPECT_FALSE(rig.ring->tick(4));
  EXPECT_EQ(rig.left[1].size(), 1u);
}

// Everybody sends to everybody as fast as it can; consumers stall at random.
void saturate(std::size_t processors, std::uint32_t bits, std::uint32_t places) {
  constexpr std::uint32_t kRays = 2000;
  RingRig rig(processors, bits, places, 2);
  std::mt19937 random(static_cast<unsigned>(processors * 1000 + bits));
  std::vector<int> seen(kRays, 0);
  std::uint32_t made = 0, got = 0;
  for (; got < kRays && rig.now < 4'000'000; rig.tick()) {
    for (std::size_t i = 0; i < processors; ++i) {
      if (made < kRays && rig.out[i].can_push(rig.now)) {
        const std::size_t to = (i + 1 + random() % (processors - 1)) % processors;
        rig.send(i, static_cast<std::uint8_t>(to), made++);
      }
      for (Fifo<RayToken>* end : {&rig.left[i], &rig.right[i]}) {
        if (random() % 3 == 0 || !end->can_pop(rig.now)) continue;
        ASSERT_EQ(end->front().processor, i);
        ++seen[end->pop(rig.now).ray];
        ++got;
      }
    }
  }
  EXPECT_EQ(got, kRays) << "locked up with " << processors << " processors, " << places << " places";
  EXPECT_EQ(seen, std::vector<int>(kRays, 1));
  EXPECT_TRUE(rig.ring->idle());
}

TEST(Ring, NeitherLocksUpNorLosesARayWhenItIsSaturated) {
  for (const std::size_t processors : {2u, 3u, 4u, 5u, 8u, 16u}) {
    for (const std::uint32_t bits : {256u, 32u}) {
      for (const std::uint32_t places : {2u, 4u}) saturate(processors, bits, places);
    }
  }
}

// All rays go three to the right of eight: every link's entry queue is asked by transit and by its own processor.
TEST(Ring, KeepsMovingWhenEveryRayIsInTransit) {
  RingRig rig(8, 256, 2, 2);
  std::uint64_t got = 0;
  for (; rig.now < 1000; rig.tick()) {
    for (std::size_t i = 0; i < 8; ++i) {
      if (rig.out[i].can_push(rig.now)) rig.send(i, static_cast<std::uint8_t>((i + 3) % 8));
      if (rig.left[i].can_pop(rig.now)) {
        rig.left[i].pop(rig.now);
        ++got;
      }
    }
  }
  EXPECT_GT(got, 500u);
}

TEST(Ring, DescribesWhereRaysStand) {
  RingRig rig(2, 1);
  rig.send(0, 1);
  rig.tick(2);
  std::ostringstream text;
  rig.ring->dump(text);
  EXPECT_NE(text.str().find("ring: 1 rays on links"), std::string::npos);
  EXPECT_NE(text.str().find("processor 0: 0 rays wait to enter, 1 on the link to the right"), std::string::npos)
      << text.str();
}

}  // namespace
}  // namespace gicube::emu
