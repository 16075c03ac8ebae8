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
    page.text("Mean (least to most) over all scenes and views. Balance is the paper's: the mean over the processors of the part of the time in "
              "which one was busy; *holds rays* counts a processor as busy while a ray is in its queues or its pipeline, *works* only in cycles "
              "with a sample or a leap. A ray takes 256 / bits cycles a link.")
    rows = []
    for name, settings in PARTITIONS.items():
        runs = on(bench.all(), settings)
        rows.append([name, bench.spread(runs, rays_sent).text(1, 2), bench.spread(runs, links_busy).text(1, 1),
                     bench.spread(runs, bisection_mb_s).text(1, 0), percent_range(bench.spread(runs, balance_held)),
                     percent_range(bench.spread(runs, balance_working)), time_over_slab(bench, bench.all(), settings).text(1, 2)])
    page.table("partitions", ["partition", "rays sent /100 cycles", "links busy, % of cycles", "bisection MB/s",
                              "balance: holds rays", "balance: works", "time, of the slab's"], rows)
    width_sweep(bench)
    along_and_across(bench)
    partition_claims(bench, page)


def percent_range(spread):
    return f"{percent(spread.mean)} ({percent(spread.min)} to {percent(spread.max)})"


def swept(bench):
    return [bench.run(scene) for scene in ("buckyball", "head", "rock")]


def width_sweep(bench):
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
    bench.page.text("Means of the oblique views of buckyball, head and rock; the slab has links of the same width.")
    bench.page.table("link-width", ["link bits", "skewed: rays sent /100 cycles", "links busy, % of cycles", "bisection MB/s",
                                    "balance: holds rays", "balance: works", "pipeline stalled by links", "time, of the slab's"], rows)
    bench.page.chart("The paper has a balance of 76% and 1.19 times the slab's time.", "link-width-chart",
                     "Skewed blocks need wide links to be quicker than slabs", "bits of a link", "share; time of the slab's", LINK_BITS, series,
                     log_x=True)


def along_and_across(bench):
    rows, ratios = [], []
    for scene in SCENES:
        def ms(view, settings):
            return asic_ms(bench.get(bench.run(scene, view).on(settings)))
        x, y = ms("along x", SLAB), ms("along y", SLAB)
        ratios.append(ratio(x, y))
        rows.append([scene, number(x), number(y), number(ratios[-1], 2), number(ms("diagonal", SLAB)), number(ms("along x", SKEWED)),
                     number(ms("along y", SKEWED))])
    bench.page.text("A view along x sends each ray through all slabs, one after the other; one along y keeps it in one slab.")
    bench.page.table("along-slabs", ["scene", "along x, ms", "along y, ms", "times as long", "diagonal, ms", "skewed along x, ms",
                                     "skewed along y, ms"], rows)
    times = spread_of(ratios)
    bench.page.claim(10, "a view along which each ray crosses all slabs, against one across (5.4)", "about twice the time",
                     f"{times.mean:.2f} times (mean of scenes; {times.min:.2f} to {times.max:.2f})", differs(times.mean, 2),
                     "the mean follows the scenes: rays that end early in the first slab leave the others without work")


def partition_claims(bench, page):
    of_all = [on(bench.all(), settings) for settings in PARTITIONS.values()]
    sent, cut, held = ([bench.mean(runs, figure) for runs in of_all] for figure in (rays_sent, bisection_mb_s, balance_held))
    block, slab = bench.block, bench.edge // DESIGN_PROCESSORS
    by_step = {step: bench.mean([run.on(SKEWED).at_step(step) for run in bench.oblique()], rays_sent) for step in (2, 1, 0.5)}
    page.claim(7, "rays sent a processor and 100 cycles: slab, repeated slab, skewed (3.6)", "2 to 4, 7, 20",
               ", ".join(f"{value:.2f}" for value in sent), differs(sent[0], 2, 4) or differs(sent[1], 7) or differs(sent[2], 20),
               f"primary rays with half-voxel steps can't cross more often: a slab of {slab} voxels takes {2 * slab} samples to cross, so a "
               f"pipeline that never stands sends 100/{2 * slab} = {50 / slab:.2f} rays, a block of {block} voxels {50 / block:.2f} a face. The "
               "paper's numbers need scattered rays, irradiance carriers (which go to neighbours with each splat at a face) or wider steps: in "
               f"oblique views skewed blocks send {by_step[0.5]:.1f} with steps of 0.5, {by_step[1]:.1f} with 1 and {by_step[2]:.1f} with 2")
    ray_megabytes = 32 * 100  # a second, of one ray of 32 bytes a cycle at 100 MHz
    in_all = sent[2] / 100 * DESIGN_PROCESSORS * ray_megabytes
    page.claim(8, "bisection: skewed, slab (3.6)", "12 MB/s, at most 1 MB/s", f"{cut[2]:.0f} MB/s, {cut[0]:.1f} MB/s",
               differs(cut[2], 12) or differs(cut[0], 0, 1),
               "the paper's two rows exclude each other: 20 rays of 32 bytes a processor and 100 cycles are 2560 MB/s in all, of which half has "
               f"to cross the middle of a ring of four. Ours agree: skewed sends {in_all:.0f} MB/s in all, {percent(ratio(cut[2], in_all))} of it "
               "over the cut; the slab's mean is that of the views along x and the diagonal, where all rays cross it, while the views across send "
               "next to nothing")
    time = time_over_slab(bench, bench.all(), SKEWED).mean
    page.claim(9, "load balance: slab, repeated slab, skewed; skewed's time (5.4)", "91%, 92%, 76%; + 19%",
               f"{', '.join(map(percent, held))}; {100 * (time - 1):+.0f}%",
               differs(held[0], 0.91) or differs(held[1], 0.92) or differs(held[2], 0.76) or differs(time, 1.19), width_reason(bench, held[0]))


def width_reason(bench, slab_held):
    """The width of the links at which the skewed partition comes nearest to the paper."""
    paper_time = 1.19  # of the slab's
    runs = swept(bench)
    times = {bits: time_over_slab(bench, runs, SKEWED, bits).mean for bits in LINK_BITS}
    # The design's own, if another is not nearer.
    best = min((DESIGN_BITS, *LINK_BITS), key=lambda bits: abs(times[bits] - paper_time))
    nearest, slabs = on(runs, with_links(SKEWED, best)), on(runs, with_links(SLAB, best))
    works, slab_works = bench.mean(nearest, balance_working), bench.mean(slabs, balance_working)
    across = bench.mean([bench.run(scene, view) for scene in SCENES for view in ("along y", "along z")], balance_held)
    return (f"the width of the links, which the paper does not give, and what counts as busy. Links of {best} bits come nearest to the paper's "
            f"{100 * (paper_time - 1):+.0f}%: {100 * (times[best] - 1):+.0f}%; there a skewed processor holds rays "
            f"{percent(bench.mean(nearest, balance_held))} of the time but works {percent(works)} of it, {ratio(works, slab_works):.2f} of the "
            f"slab's {percent(slab_works)} (paper: 76/91 = 0.84), and is stalled by its links {percent(bench.mean(nearest, stalled_by_links))} of "
            f"it, as the paper says. At {DESIGN_BITS} bits links stall it {percent(bench.mean(on(runs, SKEWED), stalled_by_links))} of the time, "
            f"and the even spread wins. The slab's {percent(slab_held)} is the mean of all views: along y and z, across the slabs, it is "
            f"{percent(across)}")


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
    page.text("The same volume and image with more processors, against one processor of the same machine. Slabs are at least one block thick. "
              "Bound: p times the mean over the most samples that a processor has, which nothing but another partition can change.")
    page.table("speed-up", ["machine", "processors", *SCENES, "mean", "of ideal", "bound by where the samples lie", "DSP busy"], rows)
    page.chart("Oblique views.", "speed-up-chart",
               "Figure 16: many processors need a fast front end and small blocks (fixed problem, mean of the scenes)", "processors", "speed-up",
               processors, curves)

    means = [mean_of(speed_ups(settings, most)) for settings in list(machines.values())[1:]]
    lost, lost_small = (bench.lost_cycles(runs_on(settings, most)) for settings in (SKEWED, small))
    bound, bound_small = (most * bench.mean(runs_on(settings, most), work_balance) for settings in (fast, small))
    page.claim(12, "speed-up at p = 16, 256^3 and 256^2 (5.2, Figure 16)", "within 14% of ideal: at least 13.8",
               "{:.1f}; {:.1f} with ray differentials; {:.1f} with a DSP 8 times as fast; {:.1f} with both and wide links; {:.1f} with blocks of "
               "half the edge besides".format(*means), differs(means[0], 13.8, 16),
               "two causes. The DSP makes and takes a ray in 28 of its cycles, which alone takes most of the frame of 16 processors (cycles "
               f"without a sample: {lost}). And (i+j+k) mod 16 can't be even on an 8 x 8 x 8 grid of blocks (the paper itself asks that N be a "
               f"multiple of p n): where the samples lie bounds the speed-up to {bound:.1f}. A 16 x 16 x 16 grid, which is even, is bound to "
               f"{bound_small:.1f}; what is lost then is {lost_small}")


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
    page.text(f"The problem grown with p: each processor has its {bench.edge // 2}^3 voxels; the volume doubles along x, y, z for 2, 4, 8 "
              "processors, the image with its face, so that rays times their length grow as p. Throughput a processor, slabs.")
    page.table("grown", ["scene", "view", "p = 1", "2", "4", "8"],
                     [[scene, "along z, parallel rays" if parallel else "oblique", *(percent(busy[p][i], 1) for p in processors)]
                      for i, (scene, parallel) in enumerate(problems)])
    one, eight = mean_of(busy[1]), mean_of(busy[8])
    page.claim(13, "throughput a processor, problem grown with p from 1 to 8 (5.2)", "99.9% to 80.7%", f"{percent(one, 1)} to {percent(eight, 1)}",
               differs(one, 0.999) or differs(eight, 0.807),
               f"cycles without a sample, one processor: {bench.lost_cycles(runs[1])}; eight: {bench.lost_cycles(runs[8])}")


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
    page.text(f"16 processors on {edge}^3 voxels, oblique views.")
    page.table("large", ["machine", "scene", *(head for size in sizes for head in (f"{size}^2 image: throughput", *columns[1:]))], rows)

    busy = {key: bench.mean(each, throughput) for key, each in runs.items()}
    skewed, quick, no_leaps = ([busy[name, size] for size in sizes] for name in list(machines)[1:])
    lost = [bench.lost_cycles(runs[name, sizes[1]]) for name in list(machines)[1:]]
    page.claim(14, "512^3 with 16 processors: 256^2 image, 512^2 image (5.2)", "29.1%, 76.1%",
               f"{percent(skewed[0], 1)}, {percent(skewed[1], 1)} (skewed); {percent(quick[0], 1)}, {percent(quick[1], 1)} with a fast DSP, runs "
               "and wide links", differs(skewed[0], 0.291) or differs(skewed[1], 0.761),
               f"the larger image is held up by the DSP, which at 28 cycles a ray is busy {percent(bench.mean(runs['skewed', sizes[1]], dsp_use))} "
               "of the time, and by links of 32 bits; then by leaping, after which the samples that are left lie unevenly: without it, with a "
               f"fast DSP, runs and wide links throughput is {percent(no_leaps[0], 1)} and {percent(no_leaps[1], 1)}. Cycles without a sample, "
               f"{sizes[1]}^2 image: {lost[0]}; with a fast DSP, runs and wide links: {lost[1]}; without leaps: {lost[2]}")
