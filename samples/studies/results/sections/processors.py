"""Several processors: partitions of the volume, links, load balance, and scaling."""
import math

from bench import (FAST_DSP, FAST_FRONT_END, PARTITION, PROCESSORS, RUNS_OF_RAYS, SCENES, SKEWED, cells)
from figures import (asic_ms, balance_held, balance_working, bisection_mb_s, dsp_use, links_busy, mean_of, rays_sent, ratio,
                     spread_of, stalled_by_links, throughput, work_balance)
from page import differs, number, percent

PARTITIONS = {"slab": {}, "repeated slab": {PARTITION: "repeated_slab"}, "skewed": SKEWED}
SLAB = PARTITIONS["slab"]
LINK_BITS = (1, 2, 4, 8, 16, 32, 64, 256)
DESIGN_BITS, DESIGN_PROCESSORS = 32, 4


def with_links(settings, bits):
    return settings if bits == DESIGN_BITS else settings | {"link.bits": bits}


def on(runs, settings):
    return [run.on(settings) for run in runs]


def time_over_slab(bench, runs, settings, bits=DESIGN_BITS):
    """The partition's time over the slab's, of the same scene, view and link."""
    slab = bench.over(on(runs, with_links(SLAB, bits)), asic_ms)
    return spread_of([ratio(ours, theirs) for ours, theirs in zip(bench.over(on(runs, with_links(settings, bits)), asic_ms), slab)])


def partition(bench, page):
    """Rows 7 to 10."""
    page.say("partitions")
    rows = []
    for name, settings in PARTITIONS.items():
        runs = on(bench.all(), settings)
        rows.append([name, bench.spread(runs, rays_sent).text(1, 2), bench.spread(runs, links_busy).text(1, 1),
                     bench.spread(runs, bisection_mb_s).text(1, 0), percent_range(bench.spread(runs, balance_held)),
                     percent_range(bench.spread(runs, balance_working)), time_over_slab(bench, bench.all(), settings).text(1, 2)])
    page.table("partitions", ["partition", "rays sent /100 cycles", "links busy, % of cycles", "bisection MB/s",
                              "balance: holds rays", "balance: works", "time, of the slab's"], rows)
    width_sweep(bench, page)
    along_and_across(bench, page)
    partition_claims(bench, page)


def percent_range(spread):
    return f"{percent(spread.mean)} ({percent(spread.min)} to {percent(spread.max)})"


def swept(bench):
    return [bench.run(scene) for scene in ("buckyball", "head", "rock")]


def width_sweep(bench, page):
    runs = swept(bench)
    rows = []
    series = {"balance: holds rays": [], "balance: works": [], "time / slab's time": []}
    for bits in LINK_BITS:
        at = on(runs, with_links(SKEWED, bits))
        sent, busy, cut, held, works, stalled = (bench.mean(at, figure) for figure in (rays_sent, links_busy, bisection_mb_s, balance_held,
                                                                                       balance_working, stalled_by_links))
        time = time_over_slab(bench, runs, SKEWED, bits).mean
        rows.append([str(bits), number(sent, 2), number(busy), number(cut, 0), percent(held), percent(works), percent(stalled, 1), number(time, 2)])
        for values, value in zip(series.values(), (held, works, time)):
            values.append(value)
    page.say("link width")
    page.table("link-width", ["link bits", "skewed: rays sent /100 cycles", "links busy, % of cycles", "bisection MB/s",
                                    "balance: holds rays", "balance: works", "pipeline stalled by links", "time, of the slab's"], rows)
    page.chart("The paper has a balance of 76% and 1.19 times the slab's time.", "link-width-chart",
                     "Skewed blocks need wide links to be quicker than slabs", "bits of a link", "share; time of the slab's", LINK_BITS, series,
                     log_x=True)


def along_and_across(bench, page):
    rows, ratios = [], []
    for scene in SCENES:
        def ms(view, settings):
            return asic_ms(bench.get(bench.run(scene, view).on(settings)))
        x, y = ms("along x", SLAB), ms("along y", SLAB)
        ratios.append(ratio(x, y))
        rows.append([scene, number(x), number(y), number(ratios[-1], 2), number(ms("diagonal", SLAB)), number(ms("along x", SKEWED)),
                     number(ms("along y", SKEWED))])
    page.say("along slabs")
    page.table("along-slabs", ["scene", "along x, ms", "along y, ms", "times as long", "diagonal, ms", "skewed along x, ms",
                                     "skewed along y, ms"], rows)
    times = spread_of(ratios)
    page.claim(10, differs(times.mean, 2), times=times)


def partition_claims(bench, page):
    of_all = [on(bench.all(), settings) for settings in PARTITIONS.values()]
    sent, cut, held = ([bench.mean(runs, figure) for runs in of_all] for figure in (rays_sent, bisection_mb_s, balance_held))
    block, slab = bench.block, bench.edge // DESIGN_PROCESSORS
    two, one, half = (bench.mean([run.on(SKEWED).at_step(step) for run in bench.oblique()], rays_sent) for step in (2, 1, 0.5))
    page.claim(7, differs(sent[0], 2, 4) or differs(sent[1], 7) or differs(sent[2], 20), sent=sent, slab=slab, steps=2 * slab, of_slab=50 / slab,
               block=block, of_block=50 / block, half=half, one=one, two=two)
    ray_megabytes = 32 * 100  # a second, of one ray of 32 bytes a cycle at 100 MHz
    in_all = sent[2] / 100 * DESIGN_PROCESSORS * ray_megabytes
    page.claim(8, differs(cut[2], 12) or differs(cut[0], 0, 1), skewed=cut[2], slab=cut[0], in_all=in_all, over=ratio(cut[2], in_all))
    time = time_over_slab(bench, bench.all(), SKEWED).mean
    page.claim(9, differs(held[0], 0.91) or differs(held[1], 0.92) or differs(held[2], 0.76) or differs(time, 1.19), held=held,
               more=100 * (time - 1), **at_best_width(bench))


def at_best_width(bench):
    """Figures at the width of the links at which the skewed partition comes nearest to the paper's 1.19 times the slab's time."""
    runs = swept(bench)
    times = {bits: time_over_slab(bench, runs, SKEWED, bits).mean for bits in LINK_BITS}
    # The design's own, if another is not nearer.
    best = min((DESIGN_BITS, *LINK_BITS), key=lambda bits: abs(times[bits] - 1.19))
    nearest, slabs = on(runs, with_links(SKEWED, best)), on(runs, with_links(SLAB, best))
    works, slab_works = bench.mean(nearest, balance_working), bench.mean(slabs, balance_working)
    return {"best": best, "best_more": 100 * (times[best] - 1), "holds": bench.mean(nearest, balance_held), "works": works,
            "less": ratio(works, slab_works), "slab_works": slab_works, "stalled": bench.mean(nearest, stalled_by_links),
            "design_stalled": bench.mean(on(runs, SKEWED), stalled_by_links),
            "across": bench.mean([bench.run(scene, view) for scene in SCENES for view in ("along y", "along z")], balance_held)}


def speed_up(bench, page):
    """Row 12."""
    most = 16
    fast = SKEWED | FAST_FRONT_END
    small = fast | {"asic.block_voxels": max(8, bench.block // 2)}
    machines = {"slab": SLAB, "skewed": SKEWED, "skewed, runs of 64 rays": SKEWED | RUNS_OF_RAYS, "skewed, DSP 8 times as fast": SKEWED | FAST_DSP,
                "skewed, fast DSP, runs, wide links": fast, "the same, blocks of half the edge": small}
    slabs = bench.edge // bench.block  # a slab is at least a block thick

    def runs_on(settings, processors):
        return on(bench.oblique(), settings if processors == DESIGN_PROCESSORS else settings | {PROCESSORS: processors})

    def speed_ups(settings, processors):
        one, many = (bench.over(runs_on(settings, p), asic_ms) for p in (1, processors))
        return [ratio(a, b) for a, b in zip(one, many)]

    rows, processors = [], (1, 2, 4, 8, most)
    curves = {"ideal": processors} | {name: [] for name in machines}
    for name, settings in machines.items():
        ends_only = name in ("skewed, runs of 64 rays", "skewed, DSP 8 times as fast")
        for p in processors:
            if (settings == SLAB and p > slabs) or (ends_only and 1 < p < most):
                curves[name].append(math.nan)
                continue
            ups, runs = speed_ups(settings, p), runs_on(settings, p)
            mean = mean_of(ups)
            rows.append([name, str(p), *(number(up, 2) for up in ups), number(mean, 2), percent(mean / p),
                         number(p * bench.mean(runs, work_balance), 2), percent(bench.mean(runs, dsp_use))])
            curves[name].append(mean)
    page.say("speed-up")
    page.table("speed-up", ["machine", "processors", *SCENES, "mean", "of ideal", "bound by where the samples lie", "DSP busy"], rows)
    page.chart("Oblique views.", "speed-up-chart",
               "Figure 16: many processors need a fast front end and small blocks (fixed problem, mean of the scenes)", "processors", "speed-up",
               processors, curves)

    means = [mean_of(speed_ups(settings, most)) for settings in list(machines.values())[1:]]
    lost, lost_small = (bench.lost_cycles(runs_on(settings, most)) for settings in (SKEWED, small))
    bound, bound_small = (most * bench.mean(runs_on(settings, most), work_balance) for settings in (fast, small))
    page.claim(12, differs(means[0], 13.8, 16), means=means, lost=lost, bound=bound, small_bound=bound_small, small_lost=lost_small)


def scaling(bench, page):
    """Rows 13 and 14."""
    grown_problem(bench, page)
    large_problem(bench, page)


def grown(bench, scene, parallel, processors):
    """p processors, each with a box of half the design point's edge, and as many rays each."""
    half, image = bench.edge // 2, bench.image // 2
    twice = [2 if processors >= p else 1 for p in (2, 4, 8)]
    run = bench.run(scene, "along z" if parallel else "oblique", dims=tuple(half * factor for factor in twice),
                    width=image * twice[0], height=image * twice[1], orthographic=parallel)
    return run if processors == DESIGN_PROCESSORS else run.on({PROCESSORS: processors})


def grown_problem(bench, page):
    processors = (1, 2, 4, 8)
    problems = [(scene, parallel) for scene in ("cloud", "rock") for parallel in (True, False)]
    runs = {p: [grown(bench, *problem, p) for problem in problems] for p in processors}
    busy = {p: bench.over(runs[p], throughput) for p in processors}
    page.say("grown", half=bench.edge // 2)
    page.table("grown", ["scene", "view", "p = 1", "2", "4", "8"],
                     [[scene, "along z, parallel rays" if parallel else "oblique", *(percent(busy[p][i], 1) for p in processors)]
                      for i, (scene, parallel) in enumerate(problems)])
    one, eight = mean_of(busy[1]), mean_of(busy[8])
    page.claim(13, differs(one, 0.999) or differs(eight, 0.807), one=one, eight=eight, lost_one=bench.lost_cycles(runs[1]),
               lost_eight=bench.lost_cycles(runs[8]))


def large_problem(bench, page):
    edge, sizes = 2 * bench.edge, (bench.image, 2 * bench.image)
    fast = SKEWED | FAST_FRONT_END
    machines = {"slab": (SLAB, True),  # settings, leap
                "skewed": (SKEWED, True),
                "skewed, fast DSP, runs, wide links": (fast, True),
                "the same without leaps": (fast, False)}
    large = {"asic.max_volume_voxels": edge, PROCESSORS: 16}
    runs = {(name, size): [bench.run(scene, dims=3 * (edge,), edge=edge, width=size, height=size, leap=leap).on(settings | large)
                           for scene in ("buckyball", "head", "cloud")]
            for name, (settings, leap) in machines.items() for size in sizes}
    others = {"throughput": lambda m: percent(throughput(m), 1)}
    columns = ["throughput", "hit ratio", "DSP busy"]
    rows = []
    for name in machines:
        for pair in zip(*(runs[name, size] for size in sizes)):
            rows.append([name, pair[0].scene, *(cell for run in pair for cell in cells(bench.get(run), columns, others))])
    page.say("large", edge=edge)
    page.table("large", ["machine", "scene", *(head for size in sizes for head in (f"{size}^2 image: throughput", *columns[1:]))], rows)

    busy = {key: bench.mean(each, throughput) for key, each in runs.items()}
    skewed, quick, no_leaps = ([busy[name, size] for size in sizes] for name in list(machines)[1:])
    lost = [bench.lost_cycles(runs[name, sizes[1]]) for name in list(machines)[1:]]
    page.claim(14, differs(skewed[0], 0.291) or differs(skewed[1], 0.761), skewed=skewed, quick=quick, no_leaps=no_leaps, lost=lost,
               image=sizes[1], dsp=bench.mean(runs["skewed", sizes[1]], dsp_use))
