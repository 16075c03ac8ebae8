#include "board/bus/host_bus.h"

#include "firmware/register_file.h"
#include "test.h"

namespace gicube::emu {
namespace {

BusTiming timing(v1::BusModel model) {
  v1::BusConfig config;
  config.set_model(model);
  return BusTiming(config);
}

// MB/s of one burst of `dwords`.
double rate(const BusTiming& bus, TransferKind kind, std::uint32_t dwords) {
  const double seconds =
      static_cast<double>(bus.burst_clocks(BusDirection::kDown, kind, dwords) * bus.clock_ps) * 1e-12;
  return 4.0 * dwords / seconds * 1e-6;
}

Picoseconds alone(v1::BusModel model, BusDirection direction, std::uint64_t bytes) {
  HostBus bus(timing(model));
  bus.enqueue(direction, {.id = 1, .bytes = bytes});
  return bus.next_delivery(kNever)->time_ps;
}

TEST(BusTiming, PciWriteBurstsReachTheRatesOfTheClosedForm) {
  const BusTiming bus = timing(v1::pci33);
  const std::uint32_t dwords[] = {8, 16, 32, 64, 256};
  const double expected[] = {97, 112, 122, 127, 132};  // n + 3 clocks [H1101]
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(rate(bus, TransferKind::kBulk, dwords[i]), expected[i], 0.6) << dwords[i];
}

TEST(BusTiming, PciReadBurstsReachTheRatesOfTheClosedForm) {
  const BusTiming bus = timing(v1::pci33);
  const std::uint32_t dwords[] = {8, 16, 32, 64, 256};
  const double expected[] = {56, 79, 99, 114, 128};  // n + 3 + 8 clocks
  for (int i = 0; i < 5; ++i)
    EXPECT_NEAR(rate(bus, TransferKind::kRegisterRead, dwords[i]), expected[i], 0.6) << dwords[i];
}

TEST(BusTiming, AgpSustainsHalfToFourFifthsOfItsPeakOnShortReads) {
  const BusTiming bus = timing(v1::agp2x);
  EXPECT_NEAR(rate(bus, TransferKind::kBulk, 4) / 533.3, 0.5, 0.001);
  EXPECT_NEAR(rate(bus, TransferKind::kBulk, 16) / 533.3, 0.8, 0.001);
}

// Closed forms, written out apart from the code under test. A 256^3 volume is 75,497,472 bytes of packed words.
TEST(HostBus, LoadsA256CubedVolumeInTheClosedFormTimeOnEveryModel) {
  constexpr std::uint64_t kDwords = 75'497'472 / 4;
  EXPECT_EQ(alone(v1::pci33, BusDirection::kDown, kDwords * 4), kDwords / 256 * 259 * 30'000);
  EXPECT_EQ(alone(v1::agp1x, BusDirection::kDown, kDwords * 4), kDwords / 64 * (64 + 2) * 15'000);
  EXPECT_EQ(alone(v1::agp2x, BusDirection::kDown, kDwords * 4), kDwords / 64 * (32 + 2) * 15'000);
  EXPECT_EQ(alone(v1::agp4x, BusDirection::kDown, kDwords * 4), kDwords / 64 * (16 + 2) * 15'000);
}

TEST(HostBus, SendsA512SquaredFrameInTheClosedFormTimeOnEveryModel) {
  constexpr std::uint64_t kDwords = 512 * 512 * 36 / 8 / 4;
  EXPECT_EQ(alone(v1::pci33, BusDirection::kUp, kDwords * 4), kDwords / 256 * 259 * 30'000);
  for (const auto model : {v1::agp1x, v1::agp2x, v1::agp4x}) {
    EXPECT_EQ(alone(model, BusDirection::kUp, kDwords * 4), kDwords / 256 * 259 * 15'000);
  }
}

TEST(HostBus, RoundsBytesUpToDwordsAndEndsWithAShortBurst) {
  EXPECT_EQ(alone(v1::pci33, BusDirection::kDown, 4 * 256 + 1), (259 + 4) * 30'000u);
}

TEST(HostBus, SendsWholeBurstsAndTheRestWhateverTheLength) {
  for (std::uint64_t dwords = 1; dwords <= 1100; ++dwords) {
    const std::uint64_t bursts = (dwords + 255) / 256;
    ASSERT_EQ(alone(v1::pci33, BusDirection::kDown, 4 * dwords), (dwords + 3 * bursts) * 30'000) << dwords;
  }
}

// Three bursts of 259 clocks; the fourth ends at clock 1000, after 220 dwords.
TEST(HostBus, ALongTransferMakesWayWhenTheOtherDirectionBeginsToAsk) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * (3 * 256 + 220 + 256)});
  bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = 4 * 8, .ready_ps = 1000 * 30'000});
  const auto up = bus.next_delivery(kNever), down = bus.next_delivery(kNever);
  EXPECT_EQ(up->id, 2u);
  EXPECT_EQ(up->time_ps, 1011 * 30'000u);
  EXPECT_EQ(down->time_ps, (1011 + 259) * 30'000u);
  EXPECT_EQ(bus.counters(BusDirection::kDown).bursts, 5u);
}

TEST(HostBus, DeliversWhatEndsAtTheHorizonAndNothingLater) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * 8, .ready_ps = 60'000});
  bus.enqueue(BusDirection::kDown, {.id = 2, .bytes = 0});
  EXPECT_FALSE(bus.next_delivery(60'000 + 11 * 30'000 - 1));
  EXPECT_EQ(bus.next_delivery(60'000 + 11 * 30'000)->id, 1u);
  EXPECT_EQ(bus.next_delivery(60'000 + 11 * 30'000)->id, 2u) << "of no bytes: it begins and ends there";
}

TEST(HostBus, GivesATransferOfNoBytesNoTime) { EXPECT_EQ(alone(v1::pci33, BusDirection::kDown, 0), 0u); }

TEST(HostBus, KeepsTheOrderOfADirectionWhateverTheReadyTimes) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4, .ready_ps = 1'000'000});
  bus.enqueue(BusDirection::kDown, {.id = 2, .bytes = 4, .ready_ps = 0});
  EXPECT_EQ(bus.next_delivery(kNever)->id, 1u);
  const auto second = bus.next_delivery(kNever);
  EXPECT_EQ(second->id, 2u);
  EXPECT_EQ(second->time_ps, 1'000'000u + 2 * 4 * 30'000u);
}

TEST(HostBus, SharesPciFairlyInBurstsOfTheLatencyTimerWhenBothDirectionsAsk) {
  // Two equal transfers: 61 dwords in each 64 clocks, in turns, so both end within a burst of the sum of their times.
  HostBus bus(timing(v1::pci33));
  constexpr std::uint64_t kBursts = 1000, kBytes = kBursts * 61 * 4;
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = kBytes});
  bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = kBytes});
  const auto first = bus.next_delivery(kNever), second = bus.next_delivery(kNever);
  EXPECT_EQ(second->time_ps, 2 * kBursts * 64 * 30'000);
  EXPECT_EQ(second->time_ps - first->time_ps, 64 * 30'000u);
}

TEST(HostBus, GivesTheLongerTransferLongBurstsAgainOnceTheOtherIsDone) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * (61 * 10 + 256 * 100)});
  bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = 4 * 61 * 10});
  EXPECT_EQ(bus.next_delivery(kNever)->id, 2u);
  EXPECT_EQ(bus.next_delivery(kNever)->time_ps, (2 * 10 * 64 + 100 * 259) * 30'000u);
}

TEST(HostBus, EndsARunningBurstWhenTheOtherDirectionBeginsToAskButNotBeforeTheLatencyTimer) {
  for (const std::uint64_t asked_clock : {10u, 64u, 100u, 258u}) {
    HostBus bus(timing(v1::pci33));
    bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * 256});
    bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = 4 * 8, .ready_ps = asked_clock * 30'000});
    const std::uint64_t first_burst = std::max<std::uint64_t>(asked_clock, 64);
    EXPECT_EQ(bus.next_delivery(kNever)->time_ps, (first_burst + 11) * 30'000) << asked_clock;
  }
}

TEST(HostBus, DecidesTheSameWhetherTheFutureIsKnownOrComesLater) {
  // The rival of clock 1000 is enqueued at once, or only when time has reached it.
  std::vector<Picoseconds> ends[2];
  for (const bool early : {true, false}) {
    HostBus bus(timing(v1::pci33));
    bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * 10'000});
    const BusTransfer rival{.id = 2, .bytes = 4 * 500, .ready_ps = 1000 * 30'000};
    if (early) {
      bus.enqueue(BusDirection::kUp, rival);
    } else {
      for (Picoseconds now = 0; now <= rival.ready_ps; now += 7 * 30'000) ASSERT_FALSE(bus.next_delivery(now));
      bus.enqueue(BusDirection::kUp, rival);
    }
    while (const auto delivery = bus.next_delivery(kNever)) ends[early ? 0 : 1].push_back(delivery->time_ps);
  }
  EXPECT_EQ(ends[0], ends[1]);
}

TEST(HostBus, CountsBytesTransfersBurstsAndBusyTimeOfEachDirection) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * 512});
  bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = 4 * 8, .ready_ps = 60'000'000});
  while (bus.next_delivery(kNever)) {
  }
  const BusCounters& down = bus.counters(BusDirection::kDown);
  EXPECT_EQ(down.bytes, 2048u);
  EXPECT_EQ(down.transfers, 1u);
  EXPECT_EQ(down.bursts, 2u);
  EXPECT_EQ(down.busy_ps, 2 * 259 * 30'000u);
  EXPECT_EQ(bus.counters(BusDirection::kUp).busy_ps, 11 * 30'000u);
  EXPECT_EQ(bus.counters(BusDirection::kUp).wait_ps, 0u);
}

TEST(HostBus, CountsTheTimeThatAReadyTransferWaitsForTheOtherDirection) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * 256});
  bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = 4, .ready_ps = 10 * 30'000});
  while (bus.next_delivery(kNever)) {
  }
  EXPECT_EQ(bus.counters(BusDirection::kUp).wait_ps, (64 - 10) * 30'000u);
}

// Clocks: the first transfer down takes 0 to 11, the one up 11 to 30, the second down 30 to 37.
TEST(HostBus, ATransferWaitsFromItsTurnInItsDirectionOn) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .cargo = Cargo::kTable, .bytes = 4 * 8});
  bus.enqueue(BusDirection::kDown, {.id = 2, .cargo = Cargo::kVolume, .bytes = 4 * 4, .ready_ps = 3 * 30'000});
  bus.enqueue(BusDirection::kUp, {.id = 3, .cargo = Cargo::kImage, .bytes = 4 * 16, .ready_ps = 5 * 30'000});
  const auto first = bus.next_delivery(kNever), up = bus.next_delivery(kNever), second = bus.next_delivery(kNever);
  EXPECT_EQ(first->time_ps, 11 * 30'000u);
  EXPECT_EQ(up->id, 3u);
  EXPECT_EQ(up->begin_ps, 11 * 30'000u);
  EXPECT_EQ(up->time_ps, 30 * 30'000u);
  EXPECT_EQ(second->begin_ps, 30 * 30'000u);
  EXPECT_EQ(second->time_ps, 37 * 30'000u);
  EXPECT_EQ(bus.counters(BusDirection::kDown).wait_ps, (30 - 11) * 30'000u);
  EXPECT_EQ(bus.counters(BusDirection::kUp).wait_ps, (11 - 5) * 30'000u);
  EXPECT_EQ(bus.counters(BusDirection::kDown).busy_ps, (11 + 7) * 30'000u);
  EXPECT_EQ(bus.counters(Cargo::kVolume).time_ps, (37 - 11) * 30'000u);
  EXPECT_EQ(bus.counters(Cargo::kTable).time_ps, 11 * 30'000u);
  EXPECT_EQ(bus.counters(Cargo::kImage).time_ps, (30 - 5) * 30'000u);
}

// The wait of a transfer is that before its first burst; between its bursts the other direction is served.
TEST(HostBus, WaitsBetweenBurstsAreNotCountedAgain) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * 61 * 3});
  bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = 4 * 61 * 3});
  while (bus.next_delivery(kNever)) {
  }
  EXPECT_EQ(bus.counters(BusDirection::kDown).wait_ps, 0u);
  EXPECT_EQ(bus.counters(BusDirection::kUp).wait_ps, 64 * 30'000u);
  EXPECT_EQ(bus.counters(BusDirection::kUp).bursts, 3u);
}

TEST(BusTiming, EveryCostOfTheConfigurationCountsToTheClock) {
  v1::BusConfig config;
  config.set_read_latency_clocks(9);
  config.set_max_burst_dwords(100);
  config.set_latency_timer_clocks(20);
  const BusTiming bus(config);
  EXPECT_EQ(bus.burst_clocks(BusDirection::kDown, TransferKind::kBulk, 1), 4u);
  EXPECT_EQ(bus.burst_clocks(BusDirection::kDown, TransferKind::kRegisterWrite, 2), 5u);
  EXPECT_EQ(bus.burst_clocks(BusDirection::kDown, TransferKind::kRegisterRead, 1), 13u);
  EXPECT_EQ(bus.longest_burst(BusDirection::kUp, TransferKind::kBulk), 100u);
  EXPECT_EQ(bus.dwords_within(BusDirection::kUp, TransferKind::kBulk, 20), 17u);
  EXPECT_EQ(bus.dwords_within(BusDirection::kUp, TransferKind::kBulk, 3), 1u) << "a burst moves something";
  EXPECT_EQ(bus.dwords_within(BusDirection::kUp, TransferKind::kBulk, 1000), 100u);
  EXPECT_EQ(bus.dwords_within(BusDirection::kDown, TransferKind::kRegisterRead, 20), 8u);
  config.set_model(v1::agp4x);
  const BusTiming agp(config);
  EXPECT_EQ(agp.clock_ps, 15'000u);
  EXPECT_EQ(agp.burst_clocks(BusDirection::kDown, TransferKind::kBulk, 4), 3u);
  EXPECT_EQ(agp.burst_clocks(BusDirection::kDown, TransferKind::kBulk, 5), 4u);
  EXPECT_EQ(agp.burst_clocks(BusDirection::kUp, TransferKind::kBulk, 5), 8u) << "the card writes as on PCI";
  EXPECT_EQ(agp.burst_clocks(BusDirection::kDown, TransferKind::kRegisterRead, 1), 13u);
  EXPECT_EQ(agp.longest_burst(BusDirection::kDown, TransferKind::kBulk), 64u);
  EXPECT_EQ(agp.dwords_within(BusDirection::kDown, TransferKind::kBulk, 10), 32u);
}

// Contended bursts of the configuration: 17 dwords each in 20 clocks.
TEST(HostBus, TheLatencyTimerAndTheLongestBurstAreTheConfigurations) {
  v1::BusConfig config;
  config.set_latency_timer_clocks(20);
  config.set_max_burst_dwords(100);
  HostBus bus{BusTiming(config)};
  bus.enqueue(BusDirection::kDown, {.id = 1, .bytes = 4 * 17 * 2});
  bus.enqueue(BusDirection::kUp, {.id = 2, .bytes = 4 * (17 * 2 + 100)});
  EXPECT_EQ(bus.next_delivery(kNever)->time_ps, 3 * 20 * 30'000u);
  EXPECT_EQ(bus.next_delivery(kNever)->time_ps, (4 * 20 + 103) * 30'000u);
}

TEST(HostBus, CountsTheTimeOfEachTransferByItsCargo) {
  HostBus bus(timing(v1::pci33));
  bus.enqueue(BusDirection::kDown, {.id = 1, .cargo = Cargo::kVolume, .bytes = 4 * 256});
  bus.enqueue(BusDirection::kDown, {.id = 2, .cargo = Cargo::kTable, .bytes = 4 * 8, .ready_ps = 50'000'000});
  bus.enqueue(BusDirection::kUp, {.id = 3, .cargo = Cargo::kImage, .bytes = 4 * 16, .ready_ps = 50'000'000 + 30'000});
  while (bus.next_delivery(kNever)) {
  }
  EXPECT_EQ(bus.counters(Cargo::kVolume).time_ps, 259 * 30'000u);
  EXPECT_EQ(bus.counters(Cargo::kTable).time_ps, 11 * 30'000u);
  EXPECT_EQ(bus.counters(Cargo::kImage).time_ps, (10 + 19) * 30'000u);  // waits ten clocks for the table
  EXPECT_EQ(bus.counters(Cargo::kImage).bytes, 64u);
  EXPECT_EQ(bus.counters(Cargo::kRays).transfers, 0u);
}

TEST(RegisterFile, ReadsAllOnesWhereNothingIsMappedAndKeepsItsState) {
  RegisterFile registers;
  EXPECT_EQ(registers.read(0xFF0), wire::kUnmappedRead);
  EXPECT_EQ(registers.read(wire::reg::kStep + 1), wire::kUnmappedRead);
  EXPECT_EQ(registers.read(0xFFFF'FFFC), wire::kUnmappedRead);
  EXPECT_EQ(registers.read(wire::reg::kControl), wire::kUnmappedRead);  // write-only
  EXPECT_EQ(registers.read(wire::reg::kStatus), 0u);
}

TEST(RegisterFile, RefusesWritesOfReadOnlyAndUnmappedRegistersWithAStickyBit) {
  RegisterFile registers;
  EXPECT_FALSE(registers.write(wire::reg::kProcessors, 99));
  EXPECT_EQ(registers.read(wire::reg::kProcessors), 0u);
  EXPECT_EQ(registers.read(wire::reg::kStatus), wire::kStatusBadAddress);
  EXPECT_EQ(registers.read(wire::reg::kErrorAddress), wire::reg::kProcessors);
  EXPECT_TRUE(registers.write(wire::reg::kStep, 1234));
  EXPECT_EQ(registers.read(wire::reg::kStatus), wire::kStatusBadAddress);  // still there
  EXPECT_TRUE(registers.write(wire::reg::kStatusClear, wire::kStatusBadAddress));
  EXPECT_EQ(registers.read(wire::reg::kStatus), 0u);
  EXPECT_FALSE(registers.write(0x2000'0000, 1));
}

TEST(RegisterFile, ComesBackToItsResetValuesButKeepsWhatTheConfigurationFixed) {
  RegisterFile registers;
  registers.set_fixed(wire::reg::kProcessors, 4);
  registers.write(wire::reg::kStep, 1234);
  registers.reset();
  EXPECT_EQ(registers.read(wire::reg::kStep), wire::kStepOne);
  EXPECT_EQ(registers.read(wire::reg::kProcessors), 4u);
}

TEST(PciConfigFile, SizesItsBarsByWritingOnes) {
  PciConfigFile config(0);
  config.write(wire::pci::kBar0Register, 0xFFFF'FFFF);
  EXPECT_EQ(~(config.read(wire::pci::kBar0Register) & ~0xFu) + 1, wire::kBar0Bytes);
  config.write(wire::pci::kBar2Low, 0xFFFF'FFFF);
  config.write(wire::pci::kBar2High, 0xFFFF'FFFF);
  const std::uint64_t mask =
      std::uint64_t{config.read(wire::pci::kBar2High)} << 32 | (config.read(wire::pci::kBar2Low) & ~0xFu);
  EXPECT_EQ(~mask + 1, std::uint64_t{64} << 30);
  EXPECT_EQ(config.read(0x100), wire::kUnmappedRead);
  config.write(wire::pci::kIds, 0);
  EXPECT_EQ(config.read(wire::pci::kIds) & 0xFFFF, wire::kVendorId);
}

TEST(PciConfigFile, KeepsTheInterruptLineAndTheThreeEnablesOfItsCommand) {
  PciConfigFile config(0);
  config.write(wire::pci::kInterrupt, 0xFFFF'FF0B);
  EXPECT_EQ(config.read(wire::pci::kInterrupt), 0x010Bu) << "pin INTA#, line 11";
  config.write(wire::pci::kInterrupt, 0);
  EXPECT_EQ(config.read(wire::pci::kInterrupt), 0x0100u);
  config.write(wire::pci::kCommandStatus, 0xFFFF'FFFF);
  EXPECT_EQ(config.read(wire::pci::kCommandStatus), 0x0010'0007u);
  config.write(wire::pci::kCommandStatus, 0);
  EXPECT_EQ(config.read(wire::pci::kCommandStatus), 0x0010'0000u);
}

}  // namespace
}  // namespace gicube::emu
