#include "studies/results/figures.h"

#include <gtest/gtest.h>

#include <numeric>

namespace gicube::samples::results {
namespace {

// Two processors at 100 MHz for 1000 cycles: 10 us.
Measurement measured(std::vector<Counter> counters) {
  counters.push_back({"asic.cycles", "cycle", 1000});
  Measurement m;
  m.counters = Counters(std::move(counters));
  m.time = 20'000'000;  // ps
  m.processors = 2;
  m.core_hz = 1e8;
  return m;
}

TEST(ResultFigures, TimesComeFromTheHostsClockAndTheCoreCycles) {
  const Measurement m = measured({});
  EXPECT_DOUBLE_EQ(frame_ms(m), 0.02);
  EXPECT_DOUBLE_EQ(rate_hz(m), 50'000);
  EXPECT_DOUBLE_EQ(asic_ms(m), 0.01);
}

TEST(ResultFigures, ThroughputIsSamplesAPipelineCycle) {
  const Measurement m = measured({{"processor.samples", "sample", 1500}});
  EXPECT_DOUBLE_EQ(throughput(m), 0.75);
  EXPECT_DOUBLE_EQ(samples_per_second(m), 150e6);
}

TEST(ResultFigures, MissesAreCountedInVoxelsOfEight) {
  const Measurement m = measured({{"processor.cache.checks", "sample", 100},
                                  {"processor.cache.missed_voxels", "voxel", 80},
                                  {"processor.cache.samples_with_misses.0", "sample", 60},
                                  {"processor.cache.samples_with_misses.2", "sample", 40}});
  EXPECT_DOUBLE_EQ(misses_a_sample(m), 0.8);
  EXPECT_DOUBLE_EQ(hit_ratio(m), 0.9);
  const std::vector<double> shares = miss_histogram(m);
  ASSERT_EQ(shares.size(), 9u);
  EXPECT_DOUBLE_EQ(shares[0], 0.6);
  EXPECT_DOUBLE_EQ(shares[2], 0.4);
  EXPECT_DOUBLE_EQ(std::accumulate(shares.begin(), shares.end(), 0.0), 1);
}

TEST(ResultFigures, MemoryCountsPacketsOfSixteenBytesAndBusyPins) {
  // A packet a core cycle keeps one channel busy: 1.6 GB/s.
  const Measurement m = measured({{"rdram0.data_busy", "tCYCLE", 4000},
                                  {"rdram1.data_busy", "tCYCLE", 0},
                                  {"rdram.data_busy", "tCYCLE", 4000},
                                  {"rdram.turnaround", "tCYCLE", 800},
                                  {"rdram.reads", "packet", 900},
                                  {"rdram.writes", "packet", 100}});
  EXPECT_DOUBLE_EQ(memory_gb_s(m), 1.6);
  EXPECT_DOUBLE_EQ(memory_use(m), 0.5);
  EXPECT_DOUBLE_EQ(memory_turnaround(m), 0.1);
}

TEST(ResultFigures, LinksAreCountedAProcessorAndHundredCycles) {
  const Measurement m =
      measured({{"link.rays_sent", "ray", 60}, {"link.busy", "link cycle", 480}, {"link.bisection_rays", "ray", 10}});
  EXPECT_DOUBLE_EQ(rays_sent(m), 3);
  EXPECT_DOUBLE_EQ(links_busy(m), 12);      // of two links a processor
  EXPECT_DOUBLE_EQ(bisection_mb_s(m), 32);  // 320 bytes in 10 us
}

TEST(ResultFigures, LoadBalanceIsTheMeanBusyPartOfTheTime) {
  const Measurement m = measured({{"processor.rays_held", "cycle", 1600},
                                  {"processor.cycles.busy", "cycle", 900},
                                  {"processor.cycles.leap", "cycle", 100}});
  EXPECT_DOUBLE_EQ(balance_held(m), 0.8);
  EXPECT_DOUBLE_EQ(balance_working(m), 0.5);
}

TEST(ResultFigures, WorkBalanceIsTheMeanOfTheMost) {
  EXPECT_DOUBLE_EQ(work_balance(measured({{"processor0.samples", "sample", 100},
                                          {"processor1.samples", "sample", 300},
                                          {"processor.samples", "sample", 400}})),
                   2.0 / 3);
}

TEST(ResultFigures, CauseSharesSumToOneAndLeaveOutSingleProcessors) {
  const Measurement m = measured({{"processor0.cycles.busy", "cycle", 300},
                                  {"processor.cycles.busy", "cycle", 500},
                                  {"processor.cycles.dsp", "cycle", 1500}});
  const auto shares = cause_shares(m);
  ASSERT_EQ(shares.size(), 2u);
  EXPECT_EQ(shares[0].first, "busy");
  EXPECT_DOUBLE_EQ(shares[0].second, 0.25);
  EXPECT_EQ(shares[1].first, "dsp");
  EXPECT_DOUBLE_EQ(shares[1].second, 0.75);
}

TEST(ResultFigures, TilesCountTwicePacketsWhereNothingIsCombined) {
  // 1000 cycles of one memory: of 50 changed tiles 20 were combined, 30 written, 5 of them fetched first.
  const Measurement m = measured({{"rdram0.data_busy", "tCYCLE", 400},
                                  {"rdram.data_busy", "tCYCLE", 400},
                                  {"rdram.reads", "packet", 70},
                                  {"rdram.writes", "packet", 30},
                                  {"processor.samples", "sample", 200},
                                  {"processor.splat.deposits", "deposit", 20},
                                  {"processor.splat.tiles", "tile", 50},
                                  {"processor.splat.tiles_combined", "tile", 20},
                                  {"processor.splat.tiles_fetched", "tile", 5}});
  EXPECT_DOUBLE_EQ(deposits_a_sample(m), 0.1);
  EXPECT_DOUBLE_EQ(tiles_a_deposit(m), 2.5);
  EXPECT_DOUBLE_EQ(tiles_combined(m), 0.4);
  EXPECT_DOUBLE_EQ(memory_use(m), 0.1);
  EXPECT_DOUBLE_EQ(memory_use_uncombined(m), 0.165);  // 65 packets for samples, 50 reads and 50 writes for tiles
}

TEST(ResultFigures, StaysAreSharesOfActivationsAndOfTurns) {
  const Measurement m = measured({{"processor.sorter.activations_of_rays.1", "activation", 30},
                                  {"processor.sorter.activations_of_rays.64", "activation", 10},
                                  {"processor.sorter.issued_in_activations_of_rays.1", "ray", 30},
                                  {"processor.sorter.issued_in_activations_of_rays.64", "ray", 970}});
  const std::vector<Stay> list = stays(m);
  EXPECT_DOUBLE_EQ(list[0].activations, 0.75);
  EXPECT_DOUBLE_EQ(list[6].turns, 64);
  EXPECT_DOUBLE_EQ(list[6].issued, 0.97);
  EXPECT_DOUBLE_EQ(issued_in_short_stays(m, 32), 0.03);
  EXPECT_DOUBLE_EQ(issued_in_short_stays(m, 128), 1);
}

TEST(ResultFigures, MillisecondsBeginWithTheWindow) {
  const Measurement m = measured({{"asic.block_loads.ms9", "activation", 0},
                                  {"asic.block_loads.ms10", "activation", 7},
                                  {"asic.samples.ms10", "sample", 100},
                                  {"asic.samples.ms12", "sample", 5}});
  const std::vector<Millisecond> list = milliseconds(m);
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].loads, 7);
  EXPECT_EQ(list[0].samples, 100);
  EXPECT_EQ(list[1].samples, 0);
  EXPECT_EQ(list[2].samples, 5);
}

TEST(ResultFigures, TwoWindowsAreSummed) {
  const Measurement a = measured({{"processor.samples", "sample", 500}}),
                    b = measured({{"processor.samples", "sample", 1500}, {"rdram.reads", "packet", 3}});
  const Measurement sum = sum_of(a, b);
  EXPECT_DOUBLE_EQ(throughput(sum), 0.5);
  EXPECT_DOUBLE_EQ(frame_ms(sum), 0.04);
  EXPECT_EQ(sum.counters.value("rdram.reads"), 3u);
  EXPECT_EQ(frame_ms(sum_of(a, {})), 0);
}

TEST(ResultFigures, DspIsMeasuredAgainstTheTimeOfTheAsic) {
  const Measurement m =
      measured({{"dsp.busy_ps", "ps", 5'000'000}, {"dsp.rays_taken", "ray", 40}, {"dsp.overflows", "ray", 10}});
  EXPECT_DOUBLE_EQ(dsp_use(m), 0.5);
  EXPECT_DOUBLE_EQ(overflows_a_ray(m), 0.25);
}

TEST(ResultFigures, NothingMeasuredIsZeroEverywhere) {
  const Measurement nothing;
  for (const auto figure :
       {rate_hz, asic_ms, samples_per_second, throughput, hit_ratio, memory_gb_s, memory_use, rays_sent, bisection_mb_s,
        balance_held, work_balance, dsp_use, overflows_a_ray, deposits_a_sample, tiles_a_deposit, tiles_combined,
        scatterings_a_ray, memory_use_uncombined}) {
    EXPECT_EQ(figure(nothing), 0);
  }
}

TEST(ResultFigures, SpreadIsLeastMeanAndMost) {
  const Spread spread = spread_of({3, 1, 5});
  EXPECT_EQ(spread.min, 1);
  EXPECT_DOUBLE_EQ(spread.mean, 3);
  EXPECT_EQ(spread.max, 5);
}

}  // namespace
}  // namespace gicube::samples::results
