// Estimates of series of commands whose costs are known: made of numbers, without a board.
#include <gtest/gtest.h>

#include <cmath>

#include "gicube/wire/mix64.h"
#include "sampled/sampled_series.h"

namespace gicube::emu {
namespace {

CommandCost cost(double work, double cycles, double packets = 10, double misses = 5) {
  return {.work = work,
          .took = {cycles, packets, misses},
          .dsp_cycles = cycles / 2,
          .counters = {{"asic.cycles", "cycle", static_cast<std::uint64_t>(std::lround(cycles))}}};
}

// Evenly in -1 .. 1.
double noise(std::uint64_t seed) { return static_cast<double>(wire::mix64(seed) >> 11) / (1ULL << 52) - 1; }

struct Outcome {
  double all = 0, estimate = 0, within = 0;
  int simulated = 0;
};

template <typename Cycles>
Outcome run(SampledSeries& series, int commands, const Cycles& cycles, double work = 1000) {
  Outcome outcome;
  for (int i = 0; i < commands; ++i) {
    const CommandCost truth = cost(work, cycles(i));
    outcome.all += truth.took[kSampledCycles];
    if (series.simulates_next()) {
      series.simulated(truth);
      outcome.estimate += truth.took[kSampledCycles];
      ++outcome.simulated;
    } else {
      outcome.estimate += series.estimate(work).took[kSampledCycles];
    }
  }
  outcome.within = series.within()[kSampledCycles];
  return outcome;
}

TEST(SampledSeries, SimulatesAllOfFewCommands) {
  SampledSeries series(0.5, 1);
  const Outcome outcome = run(series, SampledSeries::kFirstDifferences + 2, [](int i) { return 1e6 + i; });
  EXPECT_EQ(outcome.simulated, SampledSeries::kFirstDifferences + 2);
  EXPECT_EQ(outcome.within, 0);
}

TEST(SampledSeries, OfEqualCommandsEstimatesMostAndIsRight) {
  SampledSeries series(0.01, 1);
  const Outcome outcome = run(series, 1000, [](int) { return 5e5; });
  EXPECT_NEAR(outcome.estimate, outcome.all, 1e-6 * outcome.all);
  EXPECT_LE(outcome.within, 0.0101 * outcome.all);
  // 10 one by one, four blocks of each of 2, 4 .. 32, and then one of 64.
  EXPECT_LT(outcome.simulated, 50);
}

TEST(SampledSeries, TakesTheWorkIntoAccount) {
  SampledSeries series(0.01, 1);
  double all = 0, estimate = 0;
  for (int i = 0; i < 300; ++i) {
    const double work = 1000 + 2 * i;
    all += 7 * work;
    if (series.simulates_next()) {
      series.simulated(cost(work, 7 * work));
      estimate += 7 * work;
      continue;
    }
    const CommandCost thought = series.estimate(work);
    EXPECT_NEAR(thought.took[kSampledCycles], 7 * work, 1e-6 * work);
    EXPECT_NEAR(thought.dsp_cycles, 3.5 * work, 1e-6 * work);
    EXPECT_NEAR(static_cast<double>(thought.counters.at(0).value), 7 * work, 1);
    estimate += thought.took[kSampledCycles];
  }
  EXPECT_NEAR(estimate, all, 1e-6 * all);
}

TEST(SampledSeries, KeepsTheIntervalThatWasAskedForOnNoisyCommands) {
  int kept = 0;
  constexpr int kSeries = 400;
  for (std::uint64_t seed = 1; seed <= kSeries; ++seed) {
    SampledSeries series(0.03, seed);
    const Outcome outcome =
        run(series, 200, [&](int i) { return 1e6 * (1 + 0.05 * noise(1000 * seed + static_cast<std::uint64_t>(i))); });
    EXPECT_LT(outcome.simulated, 150);
    kept += std::abs(outcome.estimate - outcome.all) <= outcome.within ? 1 : 0;
  }
  // 99.7% of 400 are 398.8; fewer than 395 are one chance in a hundred of that.
  EXPECT_GE(kept, 395);
}

TEST(SampledSeries, KeepsItWhereCostsDriftAndJump) {
  int kept = 0;
  constexpr int kSeries = 400;
  for (std::uint64_t seed = 1; seed <= kSeries; ++seed) {
    SampledSeries series(0.03, seed);
    const Outcome outcome = run(series, 240, [&](int i) {
      const double wave = 0.1 * std::sin(i / 15.0 + static_cast<double>(seed));
      return 1e6 * (1 + wave + (i > 150 ? 0.2 : 0) + 0.02 * noise(1000 * seed + static_cast<std::uint64_t>(i)));
    });
    kept += std::abs(outcome.estimate - outcome.all) <= outcome.within ? 1 : 0;
  }
  EXPECT_GE(kept, 395);
}

TEST(SampledSeries, SimulatesMoreForASmallerInterval) {
  const auto cycles = [](int i) { return 1e6 * (1 + 0.05 * noise(static_cast<std::uint64_t>(i) + 1)); };
  int before = 0;
  for (const double error : {0.05, 0.01, 0.0001}) {
    SampledSeries series(error, 3);
    const Outcome outcome = run(series, 400, cycles);
    EXPECT_GT(outcome.simulated, before) << error;
    before = outcome.simulated;
  }
  EXPECT_EQ(before, 400);  // a noise of 5% allows no estimate to 0.01%
}

TEST(SampledSeries, LooksAtOnceWhereTheWorkIsUnlikeThatOfBefore) {
  SampledSeries series(0.05, 1);
  run(series, 200, [](int) { return 5e5; });
  bool has_estimated = false;
  for (int i = 0; i < 100; ++i) {
    if (series.simulates_next()) {
      series.simulated(cost(5000, 2.5e6));
      if (has_estimated) break;  // the next one is simulated after an estimate of other work
      ADD_FAILURE() << "the first of the new work was to be estimated for this test";
      break;
    }
    ASSERT_FALSE(has_estimated);
    series.estimate(5000);
    has_estimated = true;
  }
  EXPECT_TRUE(has_estimated);
}

TEST(SampledSeries, HalfTheIntervalNeverShrinks) {
  SampledSeries series(0.05, 9);
  double before = 0;
  for (int i = 0; i < 500; ++i) {
    run(series, 1, [&](int) { return 1e6 * (1 + 0.04 * noise(static_cast<std::uint64_t>(i) + 1)); });
    EXPECT_GE(series.within()[kSampledCycles], before);
    before = series.within()[kSampledCycles];
  }
  EXPECT_GT(before, 0);
}

}  // namespace
}  // namespace gicube::emu
