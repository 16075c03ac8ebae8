"""The paper's figures, computed from the counters of a measured window."""
import re
from typing import NamedTuple

PACKET_BYTES = 16  # of 9 bits: in the paper's unit, an RDRAM of 18 bit at 800 MHz has 1.6 GB/s
RAY_BYTES = 32  # [P §3.6]
CLOCKS_PER_CYCLE = 4  # tCYCLE per core cycle at the design point [P §3.3]
VOXELS_A_SAMPLE = 8  # of a trilinear neighbourhood


class Measurement:
    """Growth of a board's counters and clock in a window, usually a frame. Empty without arguments."""

    def __init__(self, counters=None, time_ps=0, processors=0, core_hz=0.0, clipped=0.0):
        self.counters = counters or {}  # in the board's order
        self.time_ps = time_ps  # simulated, as the host sees it: with bus transfers
        self.processors = processors
        self.core_hz = core_hz
        self.clipped = clipped  # of an illumination pass: the part of its energy that full irradiance words lost

    def __getitem__(self, name):
        """A counter; 0 if the board does not have it."""
        return self.counters.get(name, 0)


def ratio(part, whole):
    """0 if `whole` is 0, as before the measurements of a page."""
    return 0.0 if whole == 0 else part / whole


def to_ms(picoseconds):
    return float(picoseconds) * 1e-9


def pipeline_cycles(m):
    return m["asic.cycles"] * m.processors


def seconds(m):
    """Duration of the window in core cycles."""
    return ratio(m["asic.cycles"], m.core_hz)


def over(whole, *counters, factor=1):
    """A figure: the sum of these counters over `whole`, a counter or another figure, times `factor`."""
    def figure(m):
        return factor * ratio(sum(m[name] for name in counters), m[whole] if isinstance(whole, str) else whole(m))
    return figure


def frame_ms(m):
    """The time of the host, image transfer included."""
    return to_ms(m.time_ps)


def rate_hz(m):
    return ratio(1e3, frame_ms(m))


def asic_ms(m):
    return 1e3 * seconds(m)


samples_per_second = over(seconds, "processor.samples")
throughput = over(pipeline_cycles, "processor.samples")  # samples a pipeline cycle, 0..1
misses_a_sample = over("processor.cache.checks", "processor.cache.missed_voxels")  # 0..8


def hit_ratio(m):
    """Share of requested voxels in the cache, 0..1."""
    return 0.0 if m["processor.cache.checks"] == 0 else 1 - misses_a_sample(m) / VOXELS_A_SAMPLE


def miss_histogram(m):
    """Shares of samples with 0, 1 .. 8 misses; their sum is 1."""
    counts = [m[f"processor.cache.samples_with_misses.{misses}"] for misses in range(VOXELS_A_SAMPLE + 1)]
    return [ratio(count, sum(counts)) for count in counts]


def memory_clocks(m):
    memories = sum(1 for name in m.counters if re.fullmatch(r"rdram\d+\.data_busy", name))
    return m["asic.cycles"] * CLOCKS_PER_CYCLE * memories


memory_gb_s = over(seconds, "rdram.reads", "rdram.writes", factor=PACKET_BYTES * 1e-9)
# Shares of the time, 0..1: the memories' data pins were busy; they waited between reads and writes.
memory_use = over(memory_clocks, "rdram.data_busy")
memory_turnaround = over(memory_clocks, "rdram.turnaround")


def memory_use_uncombined(m):
    """memory_use() with a separate read and write of each changed tile, as in [P §3.6]. Above 1 the memory would stall
    the pipelines."""
    more = 2 * m["processor.splat.tiles"] - m["rdram.writes"] - m["processor.splat.tiles_fetched"]
    return memory_use(m) + ratio(more, memory_clocks(m) / CLOCKS_PER_CYCLE)


rays_sent = over(pipeline_cycles, "link.rays_sent", factor=100)  # per processor and 100 cycles
# of 100 cycles, those with bits on one of its two links
links_busy = over(pipeline_cycles, "link.busy", factor=100 / 2)
bisection_mb_s = over(seconds, "link.bisection_rays", factor=RAY_BYTES * 1e-6)  # rays over the halving cut
# Mean over the processors of the busy part of the time [P §5.4]: with rays; with rays and without stalls by links, as
# there; with a sample or leap in the pipeline.
balance_held = over(pipeline_cycles, "processor.rays_held")
balance_working = over(pipeline_cycles, "processor.cycles.busy", "processor.cycles.leap")


def balance_busy(m):
    return balance_held(m) - ratio(m["processor.cycles.link"], pipeline_cycles(m))


def work_balance(m):
    """Balance of the samples: the processors' mean over the maximum of one, 0..1. The speed-up of p processors is at
    most p times this."""
    samples = spread_of([m[f"processor{i}.samples"] for i in range(m.processors)])
    return ratio(samples.mean, samples.max)


def dsp_use(m):
    """0..1."""
    return ratio(to_ms(m["dsp.busy_ps"]), asic_ms(m))


overflows_a_ray = over("dsp.rays_taken", "dsp.overflows")
# Lighting passes.
deposits_a_sample = over("processor.samples", "processor.splat.deposits")
tiles_a_deposit = over("processor.splat.deposits", "processor.splat.tiles")  # changed tiles
# share written with an earlier change, 0..1
tiles_combined = over("processor.splat.tiles", "processor.splat.tiles_combined")
scatterings_a_ray = over("dsp.rays_taken", "pipeline.scatterings")  # rays scattered per ray sent for the first time


def cause_shares(m):
    """Shares of the pipeline cycles by cause; their sum is 1."""
    prefix = "processor.cycles."
    counts = {name.removeprefix(prefix): m[name] for name in m.counters if name.startswith(prefix)}
    return [(name, ratio(count, sum(counts.values()))) for name, count in counts.items()]


def stalled_by_links(m):
    """Share of the pipelines' cycles with a ray that waits for a link."""
    return dict(cause_shares(m)).get("link", 0.0)


def sum_of(a, b):
    """The sum of both windows; empty if one of them is."""
    if a.processors == 0 or b.processors == 0:
        return Measurement()
    counters = {name: value + a[name] for name, value in b.counters.items()}
    return Measurement(counters, a.time_ps + b.time_ps, a.processors, a.core_hz, a.clipped)


class Residency(NamedTuple):
    """Samples and leaps (steps) by their number per activation of a queue."""
    steps: int  # at least 1, 2, 4 .. and fewer than twice as many
    activations: float  # share of all, 0..1
    issued: float  # share of the steps, 0..1


def residencies(m):
    sizes = [1 << i for i in range(21)]
    activations = [m[f"processor.sorter.activations_of_rays.{size}"] for size in sizes]
    issued = [m[f"processor.sorter.issued_in_activations_of_rays.{size}"] for size in sizes]
    return [Residency(size, ratio(a, sum(activations)), ratio(i, sum(issued))) for size, a,
            i in zip(sizes, activations, issued)]


def issued_in_short_residencies(m, steps=32):
    """Share of steps in shorter residencies. Those shorter than the pipeline end before a ray returns [P §5.1]."""
    return sum((each.issued for each in residencies(m) if each.steps < steps), 0.0)


class Millisecond(NamedTuple):
    loads: float = 0.0  # of blocks
    samples: float = 0.0


def milliseconds(m):
    """Block loads and samples per millisecond of the window."""
    loads, samples = ({int(name.removeprefix(prefix)): float(value) for name, value in m.counters.items() if value
                       and name.startswith(prefix)}
                      for prefix in ("asic.block_loads.ms", "asic.samples.ms"))
    times = loads.keys() | samples.keys()
    return [Millisecond(loads.get(ms, 0.0), samples.get(ms, 0.0))
            for ms in range(min(times), max(times) + 1)] if times else []


class Spread(NamedTuple):
    min: float = 0.0
    mean: float = 0.0
    max: float = 0.0

    def times(self, factor):
        return Spread(*(factor * value for value in self))

    def text(self, unit, digits):
        """"MEAN (MIN to MAX)" in this unit, with so many decimals."""
        low, mean, high = (f"{value / unit:.{digits}f}" for value in self)
        return f"{mean} ({low} to {high})"


def spread_of(values):
    mean = 0.0
    for value in values:
        mean += value / len(values)
    return Spread(min(values), mean, max(values)) if values else Spread()


def mean_of(values):
    return spread_of(values).mean
