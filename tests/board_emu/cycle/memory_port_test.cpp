// The memory's clock is its own: what a channel brings in a second follows from its pins, whatever the core's clock.
#include "cycle/memory_port.h"

#include "machine_rig.h"
#include "test.h"

namespace gicube::emu {
namespace {

// Of one client that asks for tiles one after the other, as many at once as it may.
double packets_per_us(const v1::BoardConfig& config) {
  constexpr int kPackets = 4000;
  constexpr std::uint32_t kTiles = 64;  // of a row or two
  MissQueue misses(32);
  WriteQueue writes(32);
  MemoryPort port(config, {{&misses, &writes}}, 4);
  Cycle now = 0;
  std::uint32_t asked = 0;
  for (int taken = 0; taken < kPackets; ++now) {
    if (!misses.empty() && misses.oldest().arrival <= now) {
      misses.take();
      ++taken;
    }
    if (misses.room() > 0) misses.ask(now, 0, asked++ % kTiles);
    port.tick(now);
  }
  return kPackets * (config.asic().core_khz() / 1000.0) / static_cast<double>(now);
}

// 16 bytes in 10 ns: 1.6 GB/s, by RDRAM of 800 MHz and two bytes, and by DDR of 200 MHz and eight.
TEST(MemoryPort, BringsAHundredPacketsAMicrosecondAtMost) {
  for (const std::string memory : {"rdram", "ddr"}) {
    for (const int core_khz : {100'000, 133'333, 150'000, 200'000, 400'000, 1'000'000}) {
      const double rate =
          packets_per_us(config_with({"memory=" + memory, "asic.core_khz=" + std::to_string(core_khz)}));
      EXPECT_LE(rate, 100) << memory << ", core of " << core_khz << " kHz";
      EXPECT_GE(rate, 94) << memory << ", core of " << core_khz << " kHz";
    }
    const double slow = packets_per_us(config_with({"memory=" + memory, "asic.core_khz=20000"}));
    EXPECT_NEAR(slow, 20, 0.2) << "a core that asks for one a cycle";
  }
}

TEST(MemoryPort, BringsTwiceAsManyWithTwiceTheMemorysClock) {
  EXPECT_NEAR(packets_per_us(config_with({"rdram.clock_khz=800000", "asic.core_khz=400000"})), 2 * 97, 6);
}

TEST(MemoryPort, ServesItsClientsInTurn) {
  std::array<MissQueue, 2> misses{MissQueue(32), MissQueue(32)};
  std::array<WriteQueue, 2> writes{WriteQueue(32), WriteQueue(32)};
  MemoryPort port(config_with({"memory=rdram"}), {{&misses[0], &writes[0]}, {&misses[1], &writes[1]}}, 4);
  std::array<std::uint32_t, 2> asked{}, taken{};
  for (Cycle now = 0; now < 20'000; ++now) {
    for (std::size_t client = 0; client < 2; ++client) {
      if (!misses[client].empty() && misses[client].oldest().arrival <= now) {
        misses[client].take();
        ++taken[client];
      }
      if (misses[client].room() > 0) misses[client].ask(now, 0, asked[client]++ % 64);
    }
    port.tick(now);
  }
  EXPECT_GT(taken[0], 1000u);
  EXPECT_NEAR(taken[0], taken[1], 2);
}

}  // namespace
}  // namespace gicube::emu
