// The timeline tells what it decides, and knows a turn at the DSP ahead of its time.
#include "board/timeline.h"
#include "config/config.h"
#include "test.h"

namespace gicube::emu {
namespace {

class Notes : public BoardObserver {
 public:
  void transferred(const BusDelivery& delivery) override { deliveries.push_back(delivery); }
  void served(const BusTransaction&, Picoseconds begin, Picoseconds end) override { turns.emplace_back(begin, end); }

  std::vector<BusDelivery> deliveries;
  std::vector<std::pair<Picoseconds, Picoseconds>> turns;
};

TEST(TimelineWatcher, HearsOfBothWaysAndTheTurnBetween) {
  Timeline timeline(BusTiming(resolve({}).bus()), 200'000);
  Notes notes;
  timeline.set_watcher(&notes);
  timeline.add(
      0, 1,
      {.cargo = Cargo::kCommand, .down_bytes = 112, .dsp = true, .dsp_cycles = 1000, .up_bytes = 4, .watched = true});
  const Picoseconds end = timeline.finish(1);
  ASSERT_EQ(notes.deliveries.size(), 2u);
  ASSERT_EQ(notes.turns.size(), 1u);
  const Picoseconds down = (28 + 3) * kPciClockPs;
  EXPECT_EQ(notes.deliveries[0].begin_ps, 0u);
  EXPECT_EQ(notes.deliveries[0].time_ps, down);
  EXPECT_EQ(notes.deliveries[0].bytes, 112u);
  EXPECT_EQ(notes.deliveries[0].cargo, Cargo::kCommand);
  EXPECT_EQ(notes.turns[0], std::pair(down, down + 5'000'000));
  EXPECT_EQ(notes.deliveries[1].begin_ps, down + 5'000'000);
  EXPECT_EQ(notes.deliveries[1].time_ps, end);
  EXPECT_EQ(notes.deliveries[1].cargo, Cargo::kCompletion);
}

TEST(TimelineWatcher, TransfersOfADirectionNeverOverlap) {
  Timeline timeline(BusTiming(resolve({}).bus()), 200'000);
  Notes notes;
  timeline.set_watcher(&notes);
  std::mt19937 engine(3);
  for (std::uint64_t id = 1; id < 200; ++id) {
    timeline.add(id * 2'000'000, id,
                 {.down_bytes = engine() % 800, .dsp = true, .dsp_cycles = engine() % 500, .up_bytes = engine() % 800});
  }
  timeline.advance(Picoseconds{1} << 40);
  EXPECT_EQ(notes.turns.size(), 199u);
  std::map<BusDirection, Picoseconds> end;
  for (const BusDelivery& delivery : notes.deliveries) {
    EXPECT_GE(delivery.begin_ps, end[delivery.direction]);
    EXPECT_GE(delivery.time_ps, delivery.begin_ps);
    end[delivery.direction] = delivery.time_ps;
  }
}

// What comes later can't change it, and asking changes nothing.
TEST(Timeline, KnowsTheBeginOfATurnBeforeItsTime) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 engine(seed);
    Timeline timeline(BusTiming(resolve({}).bus()), 200'000), silent = timeline;
    Notes notes;
    timeline.set_watcher(&notes);
    std::vector<Picoseconds> foretold;
    Picoseconds now = 0;
    for (std::uint64_t id = 1; id < 60; ++id) {
      now += engine() % 3 == 0 ? engine() % 20'000'000 : 0;
      BusTransaction transaction;
      transaction.kind = engine() % 2 == 0 ? TransferKind::kBulk : TransferKind::kRegisterWrite;
      transaction.down_bytes = engine() % 2000;
      transaction.dsp = engine() % 2 == 0;
      if (transaction.dsp) foretold.push_back(timeline.turn_of(now, transaction));
      transaction.dsp_cycles = engine() % 1000;
      transaction.asic_ps = engine() % 4'000'000;
      transaction.up_bytes = engine() % 3 == 0 ? engine() % 4000 : 0;
      timeline.add(now, id, transaction);
      silent.add(now, id, transaction);
    }
    timeline.advance(Picoseconds{1} << 40);
    silent.advance(Picoseconds{1} << 40);
    ASSERT_EQ(notes.turns.size(), foretold.size());
    for (std::size_t i = 0; i < foretold.size(); ++i) EXPECT_EQ(notes.turns[i].first, foretold[i]);
    EXPECT_EQ(timeline.dsp_busy_ps(), silent.dsp_busy_ps());
    EXPECT_EQ(timeline.bus().counters(BusDirection::kUp).busy_ps, silent.bus().counters(BusDirection::kUp).busy_ps);
    EXPECT_EQ(timeline.bus().counters(BusDirection::kDown).wait_ps, silent.bus().counters(BusDirection::kDown).wait_ps);
  }
}

}  // namespace
}  // namespace gicube::emu
