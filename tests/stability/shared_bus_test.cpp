// Several boards on one bus: when they are done by the even spread of each phase's transfers, and by a bus that serves
// their bursts in turn.
#include "board/group/shared_bus.h"
#include "stability.h"
#include "test.h"

namespace gicube::stability {
namespace {

constexpr Picoseconds kBurst = 8;  // us: 256 dwords of PCI

// The schedule of a board: it works, then transfers, and again.
struct Turn {
  Picoseconds work = 0, transfer = 0;
};
using Turns = std::vector<Turn>;

BusPhase phase_of(const Turns& turns) {
  BusPhase phase;
  for (const Turn& turn : turns) {
    phase.elapsed += turn.work + turn.transfer;
    phase.busy += turn.transfer;
  }
  return phase;
}

// The bus takes a burst of the next board in the ring that wants one; else it waits for the first that will.
Picoseconds by_bursts(const std::vector<Turns>& boards) {
  struct Side {
    std::size_t turn = 0;
    Picoseconds ready = 0, left = 0;
  };
  std::vector<Side> sides(boards.size());
  Picoseconds last = 0, now = 0;
  const auto begin = [&](std::size_t i, Picoseconds time) {
    Side& side = sides[i];
    side.ready = time;
    for (; side.turn < boards[i].size(); ++side.turn) {
      side.ready += boards[i][side.turn].work;
      side.left = boards[i][side.turn].transfer;
      if (side.left > 0) return;
    }
    last = std::max(last, side.ready);
  };
  for (std::size_t i = 0; i < boards.size(); ++i) begin(i, 0);
  for (std::size_t served = 0;;) {
    std::size_t next = boards.size();
    for (std::size_t k = 1; k <= boards.size(); ++k) {
      const std::size_t i = (served + k) % boards.size();
      if (sides[i].turn == boards[i].size()) continue;
      const bool sooner = next == boards.size() || std::max(now, sides[i].ready) < std::max(now, sides[next].ready);
      if (sooner) next = i;
    }
    if (next == boards.size()) return last;
    Side& side = sides[next];
    const Picoseconds burst = std::min(kBurst, side.left);
    now = std::max(now, side.ready) + burst;
    side.left -= burst;
    served = next;
    if (side.left > 0) continue;
    ++side.turn;
    begin(next, now);
  }
}

Picoseconds by_even_spread(const std::vector<Turns>& boards) {
  std::vector<std::vector<BusPhase>> phases;
  for (const Turns& turns : boards) phases.push_back({phase_of(turns)});
  return std::ranges::max(done_on_shared_bus(phases));
}

std::vector<Turns> random_boards(std::mt19937& random, int turns, int longest) {
  std::vector<Turns> boards(std::uniform_int_distribution<std::size_t>(2, 16)(random));
  for (Turns& board : boards) {
    const int most = std::uniform_int_distribution(1, longest)(random);
    for (int i = 0; i < turns; ++i) {
      const auto any = [&](int limit) {
        return static_cast<Picoseconds>(std::uniform_int_distribution(0, limit)(random));
      };
      board.push_back({any(longest), any(most)});
    }
  }
  return boards;
}

// Whoever is not done works, transfers, or waits while another transfers. So no way of serving takes longer than all
// transfers and the most work, or less than the longest board or all transfers: the two differ by no more than the most
// work.
TEST(StabilityOfASharedBus, TheEvenSpreadIsOffByNoMoreThanTheMostWorkOfABoard) {
  std::mt19937 random(1);
  double worst = 0;
  for (int i = 0; i < 5000; ++i) {
    const auto boards = random_boards(random, 1 + static_cast<int>(random() % 5), 1000);
    Picoseconds longest = 0, transfers = 0, work = 0;
    for (const Turns& turns : boards) {
      const BusPhase phase = phase_of(turns);
      longest = std::max(longest, phase.elapsed);
      work = std::max(work, phase.elapsed - phase.busy);
      transfers += phase.busy;
    }
    for (const Picoseconds whole : {by_bursts(boards), by_even_spread(boards)}) {
      ASSERT_GE(whole + 1, std::max(longest, transfers));
      ASSERT_LE(whole, transfers + work + 1);
    }
    worst = std::max(
        worst, std::abs(1 - static_cast<double>(by_even_spread(boards)) / static_cast<double>(by_bursts(boards))));
  }
  record("shared_bus_few_transfers_worst", worst);
  EXPECT_LT(worst, 0.5);
  EXPECT_GT(worst, 0.05);
}

TEST(StabilityOfASharedBus, TheEvenSpreadIsWithinAFifthWhereAPhaseHasHundredsOfTransfers) {
  std::mt19937 random(2);
  double worst = 0;
  for (int i = 0; i < 300; ++i) {
    const auto boards = random_boards(random, 300, 60);
    worst = std::max(
        worst, std::abs(1 - static_cast<double>(by_even_spread(boards)) / static_cast<double>(by_bursts(boards))));
  }
  record("shared_bus_many_transfers_worst", worst);
  EXPECT_LT(worst, 0.2);  // most where the boards together ask for just the whole bus: transfers meet by chance
}

// All boards transfer half of their time, at first: N transfers one after the other and then the last one's work, of
// which the even spread hides all.
TEST(StabilityOfASharedBus, TransfersAtTheBeginningOfAPhaseAreTheWorstForIt) {
  for (const std::size_t count : {2u, 4u, 16u}) {
    const std::vector<Turns> boards(count, Turns{{0, 800}, {800, 0}});
    EXPECT_EQ(by_bursts(boards), count * 800 + 800);
    EXPECT_EQ(by_even_spread(boards), std::max<Picoseconds>(count * 800, 1600));
  }
}

}  // namespace
}  // namespace gicube::stability
