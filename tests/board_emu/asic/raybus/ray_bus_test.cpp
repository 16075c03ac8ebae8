// The ray bus: one packet a cycle in all, runs of two packets, turns and waits.
#include "asic/raybus/ray_bus.h"

#include "test.h"

namespace gicube::emu {
namespace {

RayToken ray(std::uint32_t id, std::uint8_t processor) { return {.ray = id, .processor = processor}; }

struct BusRig {
  explicit BusRig(std::size_t processors, std::size_t places = 8)
      : ends(processors, Fifo<RayToken>(places)), pool(static_cast<std::uint32_t>(processors)) {
    std::vector<Fifo<RayToken>*> to;
    for (Fifo<RayToken>& end : ends) to.push_back(&end);
    bus = std::make_unique<RayBus>(down, runs, pool, to);
  }
  void tick(int cycles = 1) {
    while (cycles-- > 0) bus->tick(now++);
  }

  Cycle now = 0;
  Fifo<RayToken> down{64};
  Fifo<RunPool::Run> runs{64};
  std::vector<Fifo<RayToken>> ends;
  RunPool pool;
  std::unique_ptr<RayBus> bus;
};

TEST(RayBus, SendsOneRayACycleInAll) {
  BusRig rig(4, 16);
  for (std::uint32_t i = 0; i < 40; ++i) rig.down.push(i, ray(i, i % 4));
  rig.now = 40;
  rig.tick(16);
  for (const Fifo<RayToken>& end : rig.ends) EXPECT_EQ(end.size(), 4u);  // one each p cycles
  EXPECT_EQ(rig.bus->counters().rays, 16u);
  EXPECT_EQ(rig.bus->counters().busy, 16u);
  EXPECT_EQ(rig.bus->counters().waits, 0u);
}

TEST(RayBus, BringsARayInOneCycle) {
  BusRig rig(2);
  rig.down.push(0, ray(7, 1));
  rig.tick(2);
  ASSERT_TRUE(rig.ends[1].can_pop(2));
  EXPECT_EQ(rig.ends[1].pop(2).ray, 7u);
  EXPECT_TRUE(rig.ends[0].empty());
}

TEST(RayBus, WaitsAtTheHeadForAnOwnerWithoutRoom) {
  BusRig rig(2, 1);
  rig.down.push(0, ray(1, 0));
  rig.down.push(1, ray(2, 0));
  rig.down.push(2, ray(3, 1));
  rig.now = 3;
  rig.tick(5);
  EXPECT_EQ(rig.down.size(), 2u);  // ray 3 has room but stands behind ray 2
  EXPECT_EQ(rig.bus->counters().waits, 4u);
  rig.ends[0].pop(8);
  rig.now = 9;
  rig.tick(2);
  EXPECT_TRUE(rig.down.empty());
}

TEST(RayBus, SendsARunInTwoPacketsAndLetsEachProcessorExtrapolateItsOwnRays) {
  BusRig rig(2);
  const std::vector<RayToken> run{ray(0, 0), ray(1, 1), ray(2, 1), ray(3, 0), ray(4, 1)};
  rig.runs.push(0, rig.pool.add(run));
  rig.tick(3);  // packets in cycles 1 and 2
  EXPECT_EQ(rig.bus->counters().busy, 2u);
  EXPECT_TRUE(rig.ends[0].empty());
  EXPECT_FALSE(rig.bus->idle());
  rig.tick();  // 3: one each
  EXPECT_EQ(rig.ends[0].size(), 1u);
  EXPECT_EQ(rig.ends[1].size(), 1u);
  rig.tick(2);
  EXPECT_TRUE(rig.bus->idle());
  EXPECT_EQ(rig.pool.in_use(), 0u);
  for (const std::uint32_t id : {1u, 2u, 4u}) EXPECT_EQ(rig.ends[1].pop(rig.now++).ray, id);
  for (const std::uint32_t id : {0u, 3u}) EXPECT_EQ(rig.ends[0].pop(rig.now++).ray, id);
  EXPECT_EQ(rig.bus->counters().run_rays, 5u);
}

TEST(RayBus, BuffersTwoRunsAProcessorAndThenWaits) {
  BusRig rig(2, 1);  // nobody takes the rays
  const std::vector<RayToken> run{ray(0, 0), ray(1, 0), ray(2, 0)};
  for (Cycle c = 0; c < 4; ++c) rig.runs.push(c, rig.pool.add(run));
  rig.now = 4;
  rig.tick(20);
  EXPECT_EQ(rig.bus->counters().runs, 2u);
  EXPECT_EQ(rig.bus->counters().busy, 4u);
  EXPECT_EQ(rig.bus->counters().waits, 16u);
  EXPECT_EQ(rig.pool.in_use(), 4u);
}

TEST(RayBus, DropsARunAtAProcessorThatHasNoRayInIt) {
  BusRig rig(3, 32);
  const std::vector<RayToken> first(8, ray(0, 0)), others(8, ray(1, 1));
  rig.runs.push(0, rig.pool.add(first));
  for (Cycle c = 1; c < 3; ++c) rig.runs.push(c, rig.pool.add(others));
  rig.now = 3;
  rig.tick(6);
  EXPECT_EQ(rig.bus->counters().runs, 3u);  // processor 1 has both its buffers for the second and third
}

TEST(RayBus, LetsRaysAndRunsTakeTurns) {
  BusRig rig(2, 64);
  const std::vector<RayToken> run{ray(0, 1)};
  for (std::uint32_t i = 0; i < 30; ++i) {
    rig.down.push(i, ray(i, 0));
    rig.runs.push(i, rig.pool.add(run));
  }
  rig.now = 30;
  rig.tick(30);
  EXPECT_EQ(rig.bus->counters().rays, 10u);  // one cycle each
  EXPECT_EQ(rig.bus->counters().runs, 10u);  // two cycles each
  EXPECT_EQ(rig.bus->counters().busy, 30u);
}

TEST(RayBus, LetsRaysAndExtrapolatedRaysForOneProcessorTakeTurns) {
  BusRig rig(1, 64);
  rig.runs.push(0, rig.pool.add(std::vector<RayToken>(8, ray(100, 0))));
  rig.now = 1;
  rig.tick(2);
  for (std::uint32_t i = 0; i < 8; ++i) rig.down.push(3 + i, ray(i, 0));
  rig.now = 3;
  rig.tick(8);
  EXPECT_EQ(rig.bus->counters().rays + rig.bus->counters().run_rays, 8u);
  EXPECT_NEAR(static_cast<double>(rig.bus->counters().rays), 4, 1);
}

TEST(RayBus, LosesAndDoublesNoRayUnderRandomTraffic) {
  constexpr std::uint32_t kRays = 5000;
  BusRig rig(5, 3);
  std::mt19937 random(9);
  std::vector<int> seen(kRays, 0);
  std::uint32_t made = 0, got = 0;
  for (; got < kRays && rig.now < 50'000; rig.tick()) {
    const auto owner = [&] { return static_cast<std::uint8_t>(random() % 5); };
    if (made < kRays && random() % 2 == 0 && rig.down.can_push(rig.now)) rig.down.push(rig.now, ray(made++, owner()));
    if (made + 6 < kRays && random() % 9 == 0 && rig.runs.can_push(rig.now)) {
      std::vector<RayToken> run;
      for (auto n = 1 + random() % 6; n > 0; --n) run.push_back(ray(made++, owner()));
      rig.runs.push(rig.now, rig.pool.add(run));
    }
    for (std::uint8_t i = 0; i < 5; ++i) {
      if (random() % 3 == 0 || !rig.ends[i].can_pop(rig.now)) continue;
      const RayToken token = rig.ends[i].pop(rig.now);
      EXPECT_EQ(token.processor, i);
      ++seen[token.ray];
      ++got;
    }
  }
  EXPECT_EQ(got, kRays);
  EXPECT_EQ(seen, std::vector<int>(kRays, 1));
  EXPECT_TRUE(rig.bus->idle());
  EXPECT_EQ(rig.pool.in_use(), 0u);
}

TEST(RayBus, DescribesWhatWaits) {
  BusRig rig(2, 1);
  rig.down.push(0, ray(1, 1));
  std::ostringstream text;
  rig.bus->dump(text);
  EXPECT_NE(text.str().find("1 rays and 0 runs wait; the first ray is for processor 1"), std::string::npos)
      << text.str();
}

}  // namespace
}  // namespace gicube::emu
