import unittest

import figures
from figures import Measurement


def of(counters):
    """Two processors at 100 MHz for 1000 cycles: 10 us."""
    return Measurement(counters | {"asic.cycles": 1000}, time_ps=20_000_000, processors=2, core_hz=1e8)


class ResultFigures(unittest.TestCase):
    def equal(self, ours, expected):
        self.assertAlmostEqual(ours, expected, delta=4e-16 * abs(expected))  # as GoogleTest's EXPECT_DOUBLE_EQ, 4 ULP

    def test_TimesComeFromTheHostsClockAndTheCoreCycles(self):
        m = of({})
        self.equal(figures.frame_ms(m), 0.02)
        self.equal(figures.rate_hz(m), 50_000)
        self.equal(figures.asic_ms(m), 0.01)

    def test_ThroughputIsSamplesAPipelineCycle(self):
        m = of({"processor.samples": 1500})
        self.equal(figures.throughput(m), 0.75)
        self.equal(figures.samples_per_second(m), 150e6)

    def test_MissesAreCountedInVoxelsOfEight(self):
        m = of({"processor.cache.checks": 100, "processor.cache.missed_voxels": 80,
                "processor.cache.samples_with_misses.0": 60, "processor.cache.samples_with_misses.2": 40})
        self.equal(figures.misses_a_sample(m), 0.8)
        self.equal(figures.hit_ratio(m), 0.9)
        shares = figures.miss_histogram(m)
        self.assertEqual(len(shares), 9)
        self.equal(shares[0], 0.6)
        self.equal(shares[2], 0.4)
        self.equal(sum(shares), 1)

    def test_MemoryCountsPacketsOfSixteenBytesAndBusyPins(self):
        # A packet a core cycle keeps one channel busy: 1.6 GB/s.
        m = of({"rdram0.data_busy": 4000, "rdram1.data_busy": 0, "rdram.data_busy": 4000, "rdram.turnaround": 800,
                "rdram.reads": 900, "rdram.writes": 100})
        self.equal(figures.memory_gb_s(m), 1.6)
        self.equal(figures.memory_use(m), 0.5)
        self.equal(figures.memory_turnaround(m), 0.1)

    def test_LinksAreCountedAProcessorAndHundredCycles(self):
        m = of({"link.rays_sent": 60, "link.busy": 480, "link.bisection_rays": 10})
        self.equal(figures.rays_sent(m), 3)
        self.equal(figures.links_busy(m), 12)  # of two links a processor
        self.equal(figures.bisection_mb_s(m), 32)  # 320 bytes in 10 us

    def test_LoadBalanceIsTheMeanBusyPartOfTheTime(self):
        m = of({"processor.rays_held": 1600, "processor.cycles.busy": 900, "processor.cycles.leap": 100,
                "processor.cycles.link": 400})
        self.equal(figures.balance_held(m), 0.8)
        self.equal(figures.balance_busy(m), 0.6)
        self.equal(figures.balance_working(m), 0.5)

    def test_WorkBalanceIsTheMeanOfTheMost(self):
        self.equal(figures.work_balance(of({"processor0.samples": 100, "processor1.samples": 300,
                                            "processor.samples": 400})), 2 / 3)

    def test_CauseSharesSumToOneAndLeaveOutSingleProcessors(self):
        m = of({"processor0.cycles.busy": 300, "processor.cycles.busy": 500, "processor.cycles.dsp": 1500})
        shares = figures.cause_shares(m)
        self.assertEqual([name for name, _ in shares], ["busy", "dsp"])
        self.equal(shares[0][1], 0.25)
        self.equal(shares[1][1], 0.75)

    def test_TilesCountTwicePacketsWhereNothingIsCombined(self):
        # 1000 cycles of one memory: of 50 changed tiles 20 were combined, 30 written, 5 of them fetched first.
        m = of({"rdram0.data_busy": 400, "rdram.data_busy": 400, "rdram.reads": 70, "rdram.writes": 30,
                "processor.samples": 200, "processor.splat.deposits": 20, "processor.splat.tiles": 50,
                "processor.splat.tiles_combined": 20, "processor.splat.tiles_fetched": 5})
        self.equal(figures.deposits_a_sample(m), 0.1)
        self.equal(figures.tiles_a_deposit(m), 2.5)
        self.equal(figures.tiles_combined(m), 0.4)
        self.equal(figures.memory_use(m), 0.1)
        self.equal(figures.memory_use_uncombined(m), 0.165)  # 65 packets for samples, 50 reads and 50 writes for tiles

    def test_StaysAreSharesOfActivationsAndOfTurns(self):
        m = of({"processor.sorter.activations_of_rays.1": 30, "processor.sorter.activations_of_rays.64": 10,
                "processor.sorter.issued_in_activations_of_rays.1": 30,
                "processor.sorter.issued_in_activations_of_rays.64": 970})
        residencies = figures.residencies(m)
        self.equal(residencies[0].activations, 0.75)
        self.equal(residencies[6].steps, 64)
        self.equal(residencies[6].issued, 0.97)
        self.equal(figures.issued_in_short_residencies(m, 32), 0.03)
        self.equal(figures.issued_in_short_residencies(m, 128), 1)

    def test_MillisecondsBeginWithTheWindow(self):
        m = of({"asic.block_loads.ms9": 0, "asic.block_loads.ms10": 7, "asic.samples.ms10": 100,
                "asic.samples.ms12": 5})
        times = figures.milliseconds(m)
        self.assertEqual(len(times), 3)
        self.assertEqual(times[0].loads, 7)
        self.assertEqual(times[0].samples, 100)
        self.assertEqual(times[1].samples, 0)
        self.assertEqual(times[2].samples, 5)

    def test_TwoWindowsAreSummed(self):
        a, b = of({"processor.samples": 500}), of({"processor.samples": 1500, "rdram.reads": 3})
        both = figures.sum_of(a, b)
        self.equal(figures.throughput(both), 0.5)
        self.equal(figures.frame_ms(both), 0.04)
        self.assertEqual(both["rdram.reads"], 3)
        self.assertEqual(figures.frame_ms(figures.sum_of(a, Measurement())), 0)

    def test_DspIsMeasuredAgainstTheTimeOfTheAsic(self):
        m = of({"dsp.busy_ps": 5_000_000, "dsp.rays_taken": 40, "dsp.overflows": 10})
        self.equal(figures.dsp_use(m), 0.5)
        self.equal(figures.overflows_a_ray(m), 0.25)

    def test_NothingMeasuredIsZeroEverywhere(self):
        for name in ("rate_hz", "asic_ms", "samples_per_second", "throughput", "hit_ratio", "memory_gb_s", "memory_use",
                     "rays_sent",
                     "bisection_mb_s", "balance_held", "balance_busy", "work_balance", "dsp_use", "overflows_a_ray",
                     "deposits_a_sample",
                     "tiles_a_deposit", "tiles_combined", "scatterings_a_ray", "memory_use_uncombined"):
            self.assertEqual(getattr(figures, name)(Measurement()), 0, name)

    def test_SpreadIsLeastMeanAndMost(self):
        spread = figures.spread_of([3, 1, 5])
        self.assertEqual(spread.min, 1)
        self.equal(spread.mean, 3)
        self.assertEqual(spread.max, 5)
