"""Several processors: partitions of the volume, links, load balance, and scaling."""
import math

from bench import (EVEN, IDEAL_DSP, IDEAL_FRONT_END, PARTITION, PROCESSORS, RUNS_OF_RAYS, SCENES, SKEWED, WIDE_LINKS,
                   at_paper, cells)
from figures import (asic_ms, balance_busy, balance_held, balance_working, bisection_mb_s, dsp_use, links_busy, mean_of,
                     rays_sent, ratio,
                     spread_of, stalled_by_links, throughput, work_balance)
from page import differs, number, percent

PARTITIONS = {"slab": {}, "repeated slab": {PARTITION: "repeated_slab"}, "skewed": SKEWED}
SLAB = PARTITIONS["slab"]
LINK_BITS = (1, 2, 4, 8, 12, 16, 32, 64, 256)
DESIGN_BITS, DESIGN_PROCESSORS = 32, 4


def with_links(settings, bits):
    return settings if bits == DESIGN_BITS else settings | {"link.bits": bits}


def on(runs, settings):
    return [run.on(settings) for run in runs]


def time_over_slab(bench, runs, settings, bits=DESIGN_BITS):
    """Time of the partition over that of slabs, with the same scene, view and link."""
    slab = bench.over(on(runs, with_links(SLAB, bits)), asic_ms)
    return spread_of([ratio(ours, theirs) for ours,
                      theirs in zip(bench.over(on(runs, with_links(settings, bits)), asic_ms), slab)])


def partition(bench, page):
    """Rows 7 to 10."""
    page.say("partitions")
    rows = []
    for steps, all_runs in (("paper", at_paper(bench.all())), ("half", bench.all())):
        for name, settings in PARTITIONS.items():
            runs = on(all_runs, settings)
            rows.append([steps, name, bench.spread(runs, rays_sent).text(1, 2),
                         bench.spread(runs, links_busy).text(1, 1),
                         bench.spread(runs, bisection_mb_s).text(1, 0), percent_range(bench.spread(runs, balance_held)),
                         percent_range(bench.spread(runs, balance_busy)),
                         percent_range(bench.spread(runs, balance_working)),
                         time_over_slab(bench, all_runs, settings).text(1, 2)])
    page.table("partitions", ["steps", "partition", "rays sent /100 cycles", "links busy, % of cycles",
                              "bisection MB/s",
                              "balance: holds rays", "balance: busy", "balance: works", "time, of the slab's"], rows)
    width_sweep(bench, page)
    along_and_across(bench, page)
    partition_claims(bench, page)


def percent_range(spread):
    return f"{percent(spread.mean)} ({percent(spread.min)} to {percent(spread.max)})"


def swept(bench):
    return [bench.run(scene).at_step(1).but(jitter=True) for scene in ("buckyball", "head", "rock")]


def width_sweep(bench, page):
    runs = swept(bench)
    rows = []
    series = {"balance: busy": [], "balance: works": [], "time / slab's time": []}
    for bits in LINK_BITS:
        at = on(runs, with_links(SKEWED, bits))
        sent, in_use, cut, busy, works, stalled = (bench.mean(at, figure)
                                                   for figure in (rays_sent, links_busy, bisection_mb_s, balance_busy,
                                                                                         balance_working,
                                                       stalled_by_links))
        time = time_over_slab(bench, runs, SKEWED, bits).mean
        rows.append([str(bits), number(sent, 2), number(in_use), number(cut, 0), percent(busy), percent(works),
                     percent(stalled, 1), number(time, 2)])
        for values, value in zip(series.values(), (busy, works, time)):
            values.append(value)
    page.say("link width")
    page.table("link-width", ["link bits", "skewed: rays sent /100 cycles", "links busy, % of cycles", "bisection MB/s",
                                    "balance: busy", "balance: works", "pipeline stalled by links",
                              "time, of the slab's"], rows)
    page.chart("The paper has a balance of 76% and 1.19 times the slab's time.", "link-width-chart",
                     "Skewed blocks need wide links to be quicker than slabs", "bits of a link",
               "share; time of the slab's", LINK_BITS, series,
                     log_x=True)


def along_and_across(bench, page):
    rows, ratios = [], {True: [], False: []}
    for scene in SCENES:
        def ms(view, settings, paper=False):
            run = bench.run(scene, view).on(settings)
            return asic_ms(bench.get(run.at_paper() if paper else run))
        for paper, of_steps in ratios.items():
            of_steps.append(ratio(ms("along x", SLAB, paper), ms("along y", SLAB, paper)))
        rows.append([scene, number(ms("along x", SLAB)), number(ms("along y", SLAB)), number(ratios[False][-1], 2),
                     number(ms("diagonal", SLAB)),
                     number(ms("along x", SKEWED)), number(ms("along y", SKEWED))])
    page.say("along slabs")
    page.table("along-slabs", ["scene", "along x, ms", "along y, ms", "times as long", "diagonal, ms",
                               "skewed along x, ms",
                                     "skewed along y, ms"], rows)
    times, half = spread_of(ratios[True]), spread_of(ratios[False])
    page.claim(10, differs(times.mean, 2), times=times, half=half)


def partition_claims(bench, page):
    ours, half = ([on(runs, settings) for settings in PARTITIONS.values()]
                  for runs in (at_paper(bench.all()), bench.all()))
    sent, cut, busy, in_use = ([bench.mean(runs, figure) for runs in ours]
                               for figure in (rays_sent, bisection_mb_s, balance_busy, links_busy))
    half_cut, half_busy, half_in_use = ([bench.mean(runs, figure) for runs in half]
                                        for figure in (bisection_mb_s, balance_busy, links_busy))
    whole = [bench.mean(on(runs, WIDE_LINKS), rays_sent) for runs in ours]
    page.claim(7, differs(in_use[0], 2, 4) or differs(in_use[1], 7) or differs(in_use[2], 20), in_use=in_use,
               half=half_in_use, sent=whole,
               sums=[DESIGN_PROCESSORS * each for each in whole])
    ray_megabytes = 32 * 100  # per second: one ray of 32 bytes per cycle at 100 MHz
    in_all = sent[2] / 100 * DESIGN_PROCESSORS * ray_megabytes
    page.claim(8, differs(cut[2], 12) or differs(cut[0], 0, 1), skewed=cut[2], slab=cut[0], half_skewed=half_cut[2],
               half_slab=half_cut[0],
               in_all=in_all, over=ratio(cut[2], in_all))
    time, half_time = (time_over_slab(bench, runs, SKEWED).mean for runs in (at_paper(bench.all()), bench.all()))
    page.claim(9, differs(busy[0], 0.91) or differs(busy[1], 0.92) or differs(busy[2], 0.76) or differs(time, 1.19),
               busy=busy,
               more=100 * (time - 1), half=half_busy, half_more=100 * (half_time - 1))


def speed_up(bench, page):
    """Row 12."""
    most = 16
    fast = EVEN | IDEAL_FRONT_END
    small = fast | {"asic.block_voxels": max(8, bench.block // 2)}
    machines = {"slab": SLAB, "skewed": SKEWED, "skewed evenly": EVEN,
                "skewed evenly, runs of 64 rays": EVEN | RUNS_OF_RAYS,
                "skewed evenly, ideal DSP": EVEN | IDEAL_DSP, "skewed evenly, ideal DSP, runs, wide links": fast,
                "the same, blocks of half the edge": small}
    slabs = bench.edge // bench.block  # a slab is at least a block thick

    def runs_on(settings, processors):
        return on(bench.oblique(), settings if processors == DESIGN_PROCESSORS else settings | {PROCESSORS: processors})

    def speed_ups(settings, processors):
        one, many = (bench.over(runs_on(settings, p), asic_ms) for p in (1, processors))
        return [ratio(a, b) for a, b in zip(one, many)]

    rows, processors = [], (1, 2, 4, 8, most)
    curves = {"ideal": {p: p for p in processors}}
    for name, settings in machines.items():
        ends_only = settings in (EVEN | RUNS_OF_RAYS, EVEN | IDEAL_DSP)
        for p in processors:
            if (settings == SLAB and p > slabs) or (ends_only and 1 < p < most):
                continue
            ups, runs = speed_ups(settings, p), runs_on(settings, p)
            mean = mean_of(ups)
            rows.append([name, str(p), *(number(up, 2) for up in ups), number(mean, 2), percent(mean / p),
                         number(p * bench.mean(runs, work_balance), 2), percent(bench.mean(runs, dsp_use))])
            if not ends_only:
                curves.setdefault(name, {})[p] = mean
    page.say("speed-up")
    page.table("speed-up", ["machine", "processors", *SCENES, "mean", "of ideal", "bound by where the samples lie",
                            "DSP busy"], rows)
    page.chart("Oblique views.", "speed-up-chart",
               "Figure 16: many processors need a fast front end and small blocks (fixed problem, mean of the scenes)",
               "processors", "speed-up",
               processors, {name: [curve.get(p, math.nan) for p in processors] for name, curve in curves.items()})

    def at_point(settings):
        one, many = (at_paper(on(bench.oblique(), settings | WIDE_LINKS | {PROCESSORS: p})) for p in (1, most))
        return mean_of([ratio(a, b) for a, b in zip(bench.over(one, asic_ms), bench.over(many, asic_ms))]), many

    (ours, many), (quick, _), (large, _) = map(at_point, (EVEN, EVEN | IDEAL_DSP, EVEN | {"asic.queue_rays": 1024}))
    half, even, half_fast, half_small = (mean_of(speed_ups(settings, most)) for settings in (SKEWED, EVEN, fast, small))
    # The paper's cycle-accurate simulator had one processor; in its other one the DSP is a thread without cycles [P
    # §4]. So several processors compare with a DSP without work time.
    page.claim(12, differs(quick, 13.8, 16), ours=ours, quick=quick, large=large, half=half, even=even,
               half_fast=half_fast, half_small=half_small,
               lost=bench.lost_cycles(many), bound=most * bench.mean(many, work_balance),
               uneven=most * bench.mean(runs_on(SKEWED, most), work_balance), dsp=bench.mean(many, dsp_use))


def scaling(bench, page):
    """Rows 13 and 14."""
    grown_problem(bench, page)
    large_problem(bench, page)


def grown(bench, scene, parallel, processors, paper=False):
    """p processors, each with a box of half the design point's edge, and as many rays each."""
    half, image = bench.edge // 2, bench.image // 2
    twice = [2 if processors >= p else 1 for p in (2, 4, 8)]
    run = bench.run(scene, "along z" if parallel else "oblique", dims=tuple(half * factor for factor in twice),
                    width=image * twice[0], height=image * twice[1], orthographic=parallel)
    run = run if processors == DESIGN_PROCESSORS else run.on({PROCESSORS: processors})
    return run.at_paper() if paper else run


def grown_problem(bench, page):
    processors = (1, 2, 4, 8)
    problems = [(scene, parallel) for scene in ("cloud", "rock") for parallel in (True, False)]
    runs = {p: [grown(bench, *problem, p) for problem in problems] for p in processors}
    busy = {p: bench.over(runs[p], throughput) for p in processors}
    page.say("grown", half=bench.edge // 2)
    page.table("grown", ["scene", "view", "p = 1", "2", "4", "8"],
                     [[scene, "along z, parallel rays" if parallel else "oblique",
                       *(percent(busy[p][i], 1) for p in processors)]
                      for i, (scene, parallel) in enumerate(problems)])
    ones, eights = ([grown(bench, *problem, p, True) for problem in problems] for p in (1, 8))
    one, eight = bench.mean(ones, throughput), bench.mean(eights, throughput)
    page.claim(13, differs(one, 0.999) or differs(eight, 0.807), one=one, eight=eight, half_one=mean_of(busy[1]),
               half_eight=mean_of(busy[8]),
               lost_one=bench.lost_cycles(ones), lost_eight=bench.lost_cycles(eights))


def large_problem(bench, page):
    edge, sizes = 2 * bench.edge, (bench.image, 2 * bench.image)
    fast = EVEN | IDEAL_FRONT_END
    large = {"asic.max_volume_voxels": edge, PROCESSORS: 16}
    machines = {"slab": (SLAB, True, False),  # settings, leap, at the paper's point
                "skewed": (SKEWED, True, False),
                "skewed evenly, at the paper's point": (EVEN | WIDE_LINKS, True, True),
                "skewed evenly, ideal DSP, runs, wide links": (fast, True, False),
                "the same without leaps": (fast, False, False)}

    def run_of(scene, name, size):
        settings, leap, paper = machines[name]
        run = bench.run(scene, dims=3 * (edge,), edge=edge, width=size, height=size, leap=leap).on(settings | large)
        return run.at_paper() if paper else run

    runs = {(name, size): [run_of(scene, name, size) for scene in ("buckyball", "head", "cloud")] for name in machines
            for size in sizes}
    others = {"throughput": lambda m: percent(throughput(m), 1)}
    columns = ["throughput", "hit ratio", "DSP busy"]
    rows = []
    for name in machines:
        for pair in zip(*(runs[name, size] for size in sizes)):
            rows.append([name, pair[0].scene,
                         *(cell for run in pair for cell in cells(bench.get(run), columns, others))])
    page.say("large", edge=edge)
    page.table("large", ["machine", "scene",
                         *(head for size in sizes for head in (f"{size}^2 image: throughput", *columns[1:]))], rows)

    busy = {key: bench.mean(each, throughput) for key, each in runs.items()}
    half, ours, quick, no_leaps = ([busy[name, size] for size in sizes] for name in list(machines)[1:])
    lost = [bench.lost_cycles(runs[name, sizes[1]]) for name in list(machines)[2:]]
    page.claim(14, differs(ours[0], 0.291) or differs(ours[1], 0.761), ours=ours, half=half, quick=quick,
               no_leaps=no_leaps, lost=lost, image=sizes[1])
