"""Global illumination: passes of lighting rays, and the lit frames."""
from bench import (IDEAL_DSP, IDEAL_FRONT_END, LIT_SCENES, PROCESSORS, QUEUE, SHARED_MEMORY, SKEWED, WIDE_LINKS, Bench,
                   at_paper, cells)
from figures import (Measurement, asic_ms, deposits_a_sample, frame_ms, issued_in_short_residencies, mean_of,
                     memory_gb_s, memory_turnaround,
                     memory_use, memory_use_uncombined, milliseconds, rate_hz, ratio, residencies, samples_per_second,
                     scatterings_a_ray, tiles_a_deposit, tiles_combined)
from page import differs, number, percent

BALL = "mirror-buckyball"
PAPER_SAMPLES = 122e6  # per second, lighting [P §5.1]
EVERY_SAMPLE = {"cache.splat_rule": "all_samples"}
PAPER_USE = 0.92  # of the memory interface, lighting [P §3.6]


def millions(m, name):
    return 1e-6 * m[name]


def illumination(bench, page):
    """Rows 2, 3, 5 and 6."""
    for scene in LIT_SCENES:
        page.picture(f"scene-{scene}.png", scene)
    page.table("lit-scenes", ["scene", "what it is there for"], [list(each) for each in LIT_SCENES.items()])
    page.say("illumination", edge=bench.edge)
    others = {"M rays": lambda m: number(millions(m, "dsp.lighting_rays"), 3), "pass ms": lambda m: number(frame_ms(m)),
              "deposits /100 samples": lambda m: number(100 * deposits_a_sample(m)),
              "tiles a deposit": lambda m: number(tiles_a_deposit(m), 2),
              "of them combined": lambda m: percent(tiles_combined(m)),
              "in use without combining": lambda m: percent(memory_use_uncombined(m)),
              "energy clipped": lambda m: percent(m.clipped, 1),
              "scatterings /100 rays": lambda m: number(100 * scatterings_a_ray(m))}
    columns = ["M rays", "pass ms", "M samples", "M samples/s", "throughput", "deposits /100 samples",
               "tiles a deposit", "of them combined",
               "memory GB/s", "memory in use", "in use without combining", "hit ratio", "DSP busy", "overflows a ray",
               "energy clipped"]
    passes = bench.lights() + bench.lights(True)
    albedo = {False: "low", True: "high"}
    page.table("illumination", ["scene", "albedo", *columns],
               [[run.scene, albedo[run.high_albedo], *cells(bench.get(run), columns, others)] for run in passes])
    page.say("lit causes")
    bench.causes_table("lit-causes", [f"{run.scene}, {albedo[run.high_albedo]}" for run in passes], passes)
    page.say("lit frames")
    columns = ["frame ms", "Hz", "ASIC ms", "M samples", "M samples/s", "throughput", "scatterings /100 rays",
               "memory GB/s",
               "memory in use", "hit ratio", "DSP busy"]
    page.table("lit-frames", ["scene", *columns],
               [[run.scene, *cells(bench.get(run), columns, others)] for run in bench.lit_scenes()])
    sample_claims(bench, page)
    mirrors_claim(bench, page)
    memory_claims(bench, page)


def sample_claims(bench, page):
    def text(spread):
        return spread.text(1e6, 0)
    low, high, seen = (bench.spread(at_paper(runs), samples_per_second)
                       for runs in (bench.lights(), bench.lights(True), bench.lit_scenes()))
    half_low, half_high, half_seen = (bench.spread(runs, samples_per_second)
                                      for runs in (bench.lights(), bench.lights(True), bench.lit_scenes()))
    page.claim("2 lighting", differs(low.mean, PAPER_SAMPLES) or differs(high.mean, PAPER_SAMPLES), low=text(low),
               high=text(high),
               half_low=text(half_low), half_high=text(half_high), lost=bench.lost_cycles(at_paper(bench.lights())))
    page.claim("2 scattered", differs(seen.mean, 231e6), seen=text(seen), half=text(half_seen),
               lost=bench.lost_cycles(at_paper(bench.lit_scenes())))


def mirrors_claim(bench, page):
    """Volume rendering with reflections: the reflectance map gives the light, without an illumination pass."""
    size = bench.image * 300 // 256
    half = bench.mirrors().but(width=size, height=size)
    run = half.at_paper()
    m = bench.get(run)
    page.claim(3, differs(frame_ms(m), 22.7), what=run.scene.removeprefix("mirror-"), size=size, ms=frame_ms(m),
               asic=asic_ms(m), samples=millions(m, "processor.samples"),
               scatterings=100 * scatterings_a_ray(m), bus=frame_ms(m) - asic_ms(m), half_ms=frame_ms(bench.get(half)),
               fast=frame_ms(bench.get(run.on(IDEAL_FRONT_END))), lost=bench.lost_cycles([run]))


def memory_claims(bench, page):
    low, half, fog = at_paper(bench.lights()), bench.lights(), bench.light("fog-box").at_paper()
    every = bench.get(fog.on(EVERY_SAMPLE))
    memory, use = bench.spread(low, memory_gb_s), bench.spread(low, memory_use)
    page.claim("5 lighting", differs(memory.mean, 4.6), memory=memory.text(1, 1),
               half=bench.spread(half, memory_gb_s).text(1, 1),
               deposits=100 * bench.mean(low, deposits_a_sample), tiles=bench.mean(low, tiles_a_deposit),
               combined=bench.mean(low, tiles_combined), fog=memory_gb_s(bench.get(fog)),
               fog_use=memory_use(bench.get(fog)),
               every=memory_gb_s(every), every_use=memory_use(every), every_samples=samples_per_second(every) * 1e-6,
               turnaround=memory_turnaround(every))
    page.claim("6 lighting", differs(use.mean, PAPER_USE), use=use.text(0.01, 0),
               half=bench.spread(half, memory_use).text(0.01, 0))


def light_sweep(bench, page):
    """Row 4, and figures for rows 2 and 6."""
    page.say("light sweep")
    rays_claim(bench, page)
    parameters(bench, Bench(max(32, bench.edge // 2), bench.image), page)


def rays_claim(bench, page):
    paper_pass, paper_rate = 361, 39  # ms, Hz
    one, m = bench.get(bench.light(BALL).at_paper()), bench.get(bench.lit(BALL).at_paper())
    # chosen: at most 4. A pass needs about k times the time of one with k = 1
    k = min(4, max(1, round(ratio(paper_pass, frame_ms(one)))))
    ms = frame_ms(bench.get(bench.light(BALL, k).at_paper()))
    page.claim(4, differs(ms, paper_pass) or differs(rate_hz(m), paper_rate), k=k, ms=ms, one=frame_ms(one),
               rate=rate_hz(m),
               samples=millions(m, "processor.samples"))


def parameters(bench, sized, page):
    """With volumes of the size of `sized`, a Bench."""
    variants = {"design point": {}, "1024 changed tiles wait": {"cache.write_packets": 1024}, "ideal DSP": IDEAL_DSP,
                "4 compute stages": {"pipeline.compute_stages": 4}, "8192 rays under way": {"dsp.overflow_rays": 8192},
                "cache banks of two ports": {"cache.ports": 2}, "queues of 1024 rays": {QUEUE: 1024},
                "skewed blocks": SKEWED,
                "skewed blocks, ideal DSP, wide links": SKEWED | IDEAL_DSP | WIDE_LINKS,
                "wide datapath: energies of 24 bits": {"asic.datapath": "wide"},
                "two processors share an RDRAM": SHARED_MEMORY,
                "perfect memory": {"ideal.memory": 1}, "voxel steps": {}}
    # Samples that write irradiance, its place, and the time of the write.
    write_back = {"cache.write_policy": "write_back"}
    variants |= {"voxel steps, visible samples": {"cache.splat_rule": "visible_samples"},
                 "voxel steps, all samples": EVERY_SAMPLE,
                 "voxel steps, all samples, in cells": EVERY_SAMPLE | {"cache.irradiance": "in_cells"},
                 "voxel steps, all samples, written back": EVERY_SAMPLE | write_back}
    others = {"ms": lambda m: number(asic_ms(m)), "combined": lambda m: percent(tiles_combined(m)),
              "short residencies": lambda m: percent(issued_in_short_residencies(m), 1)}
    columns = ["ms", "M samples/s", "memory GB/s", "memory in use", "combined", "short residencies"]
    swept = [BALL, "fog-box"]
    rows = []
    for name, settings in variants.items():
        runs = [sized.light(scene).on(settings).at_step(1 if name.startswith("voxel steps") else 0.5)
                for scene in swept]
        rows.append([name, *(cell for run in runs for cell in cells(bench.get(run), columns, others))])
    page.say("light parameters", edge=sized.edge, block=sized.block)
    page.table("light-parameters", ["variant", *(f"{scene}: {column}" for scene in swept for column in columns)], rows)


def tail_of(times):
    """Tail: the milliseconds at the end with fewer than half of the mean number of samples. Its shares of time, samples
    and loads, 0..1."""
    samples, loads = sum(ms.samples for ms in times), sum(ms.loads for ms in times)
    half = 0.5 * ratio(samples, len(times))
    first = len(times)
    while first > 0 and times[first - 1].samples < half:
        first -= 1
    tail = times[first:]
    return (ratio(len(tail), len(times)), ratio(sum(ms.samples for ms in tail), samples),
            ratio(sum(ms.loads for ms in tail), loads))


def block_loads(bench, page):
    """Row 18."""
    for scene in (BALL, "fog-box"):
        times = milliseconds(bench.get(bench.light(scene)))
        # for the logarithm
        series = {"block loads": [max(ms.loads, 1.0) for ms in times],
                  "samples": [max(ms.samples, 1.0) for ms in times]}
        page.chart("A block load is a queue that becomes the active one.", f"block-loads-{scene}",
                   f"Figure 15: where few rays are under way blocks are loaded often ({scene}, lighting pass)", "ms",
                   "in a millisecond",
                   range(len(times)), series, log_y=True)
    lengths = dict(zip(LIT_SCENES, bench.over(bench.lights(), residencies)))
    page.chart("Lighting passes, low albedo, k = 1.", "residencies",
               "Most steps are taken in long residencies of a queue",
               "steps of a residency, at least", "share of all steps",
               [each.steps for each in residencies(Measurement())],
               {scene: [each.issued for each in of_scene] for scene, of_scene in lengths.items()}, log_x=True)

    rows, tails, shorts = [], [], []
    for scene in LIT_SCENES:
        for part, run in (("pass", bench.light(scene)), ("frame", bench.lit(scene))):
            m = bench.get(run)
            loads = m["processor.sorter.activations"]
            short_loads = sum(each.activations for each in residencies(m) if each.steps < 32)
            time_share, sample_share, load_share = tail_of(milliseconds(m))
            short = issued_in_short_residencies(m)
            rows.append([scene, part, number(loads, 0), number(ratio(m["processor.sorter.issued"], loads)),
                         percent(1 - short, 1),
                         percent(short_loads, 1), percent(time_share, 1), percent(sample_share, 2),
                         percent(load_share, 1)])
            if part == "pass":
                tails.append(sample_share)
                shorts.append(short)
    page.say("block loads")
    page.table("block-loads", ["scene", "part", "block loads", "steps a load", "steps in residencies of 32 or more",
                               "loads in short residencies",
                               "tail: share of time", "of samples", "of block loads"], rows)

    def shorts_of(runs):
        return mean_of([issued_in_short_residencies(bench.get(run)) for run in runs])

    # The paper's exact simulator had one processor [P §4.2].
    alone = [run.on({PROCESSORS: 1}).at_paper() for run in bench.lights()]
    tail, short, half = mean_of([tail_of(milliseconds(bench.get(run)))[1]
                                 for run in alone]), shorts_of(alone), mean_of(shorts)
    ball = bench.light(BALL).at_paper()
    page.claim(18, differs(short, 0.004), long=1 - short, short=short, tail=tail, half_long=1 - half, half_short=half,
               half_tail=mean_of(tails),
               four=shorts_of(at_paper(bench.lights())), plain=shorts_of([ball]), skewed=shorts_of([ball.on(SKEWED)]),
               quick=shorts_of([ball.on(IDEAL_DSP)]),
               queues=shorts_of([ball.on({QUEUE: 1024})]), lost=bench.lost_cycles(alone))
