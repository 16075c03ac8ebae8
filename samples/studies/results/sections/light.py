"""Global illumination: passes of lighting rays, and the frames that they light."""
from bench import FAST_DSP, FAST_FRONT_END, LIT_SCENES, QUEUE, SHARED_MEMORY, SKEWED, WIDE_LINKS, cells
from figures import (Measurement, asic_ms, deposits_a_sample, frame_ms, issued_in_short_residencies, mean_of, memory_gb_s, memory_turnaround,
                     memory_use, memory_use_uncombined, milliseconds, rate_hz, ratio, residencies, samples_per_second,
                     scatterings_a_ray, tiles_a_deposit, tiles_combined)
from page import differs, number, percent

BALL = "mirror-buckyball"
PAPER_SAMPLES = 122e6  # a second, lighting [P §5.1]
PAPER_USE = 0.92  # of the memory interface, lighting [P §3.6]


def millions(m, name):
    return 1e-6 * m[name]


def illumination(bench, page):
    """Rows 2, 3, 5 and 6."""
    for scene in LIT_SCENES:
        page.picture(f"scene-{scene}.png", scene)
    page.table("lit-scenes", ["scene", "what it is there for"], [list(each) for each in LIT_SCENES.items()])
    page.text(f"The scenes of samples/scenes with {bench.edge} voxels along their longest edge, one ray per pixel, and one lighting ray per voxel "
              "of the volume's faces (k = 1) in one pass for all colours; conserving rules. *In use without combining*: if each changed tile were "
              "fetched and written on its own, as the paper's read-modify-write.")
    others = {"M rays": lambda m: number(millions(m, "dsp.lighting_rays"), 3), "pass ms": lambda m: number(frame_ms(m)),
              "deposits /100 samples": lambda m: number(100 * deposits_a_sample(m)), "tiles a deposit": lambda m: number(tiles_a_deposit(m), 2),
              "of them combined": lambda m: percent(tiles_combined(m)), "in use without combining": lambda m: percent(memory_use_uncombined(m)),
              "energy clipped": lambda m: percent(m.clipped, 1), "scatterings /100 rays": lambda m: number(100 * scatterings_a_ray(m))}
    columns = ["M rays", "pass ms", "M samples", "M samples/s", "throughput", "deposits /100 samples", "tiles a deposit", "of them combined",
               "memory GB/s", "memory in use", "in use without combining", "hit ratio", "DSP busy", "overflows a ray", "energy clipped"]
    passes = bench.lights() + bench.lights(True)
    albedo = {False: "low", True: "high"}
    page.table("illumination", ["scene", "albedo", *columns],
               [[run.scene, albedo[run.high_albedo], *cells(bench.get(run), columns, others)] for run in passes])
    page.text("Pipeline cycles of the passes by their cause; columns sum to 100%.")
    bench.causes_table("lit-causes", [f"{run.scene}, {albedo[run.high_albedo]}" for run in passes], passes)
    page.text("Frames that the passes in low albedo light, with rays scattered by mirrors and metal; half-voxel steps.")
    columns = ["frame ms", "Hz", "ASIC ms", "M samples", "M samples/s", "throughput", "scatterings /100 rays", "memory GB/s",
               "memory in use", "hit ratio", "DSP busy"]
    page.table("lit-frames", ["scene", *columns], [[run.scene, *cells(bench.get(run), columns, others)] for run in bench.lit_scenes()])
    sample_claims(bench)
    mirrors_claim(bench)
    memory_claims(bench)


def at_voxel_steps(bench):
    """Passes in low albedo with samples a voxel apart."""
    return [run.at_step(1) for run in bench.lights()]


def sample_claims(bench):
    low, high, seen = (bench.spread(runs, samples_per_second) for runs in (bench.lights(), bench.lights(True), bench.lit_scenes()))
    bench.page.claim(2, "samples a second, lighting, p=4 (5.1)", "122 M", f"low albedo mean {low.text(1e6, 0)} M, high {high.text(1e6, 0)} M",
                     differs(low.mean, PAPER_SAMPLES) or differs(high.mean, PAPER_SAMPLES),
                     "only a part of our samples deposits (next rows), so that a splat seldom stops a pipeline: of the cycles without a sample in "
                     f"low albedo most go to {bench.lost_cycles(bench.lights())}. With voxel steps, which miss more, it is mean "
                     f"{bench.spread(at_voxel_steps(bench), samples_per_second).text(1e6, 0)} M")
    bench.page.claim(2, "samples a second, rendering with scattered rays, p=4 (5.1)", "231 M", f"mean {seen.text(1e6, 0)} M",
                     differs(seen.mean, 231e6), f"cycles without a sample: {bench.lost_cycles(bench.lit_scenes())}")


def mirrors_claim(bench):
    """Volume rendering with reflections: no illumination pass, the reflectance map lights it."""
    size = bench.image * 300 // 256
    run = bench.lit("mirror-head").but(light_rays=0, width=size, height=size)
    m, apart = bench.get(run), bench.get(run.at_step(1))
    fast = bench.get(run.at_step(1).on(FAST_FRONT_END))
    bench.page.claim(3, f"head with mirrors, {size}^2 (4.1)", "22.7 ms (a scanned brain)",
                     f"{frame_ms(m):.1f} ms, of them {asic_ms(m):.1f} on the ASIC; {frame_ms(apart):.1f} with voxel steps",
                     differs(frame_ms(m), 22.7),
                     f"the scene, and the sampling distance. Ours takes {millions(m, 'processor.samples'):.1f} M samples, "
                     f"{100 * scatterings_a_ray(m):.0f} scatterings in 100 rays; {frame_ms(m) - asic_ms(m):.1f} ms of it are tables and image on "
                     f"the bus. With voxel steps it takes {millions(apart, 'processor.samples'):.1f} M samples and {frame_ms(apart):.1f} ms, and "
                     f"{frame_ms(fast):.1f} ms if a DSP eight times as fast sends runs of rays and links are wide. Cycles without a sample: "
                     f"{bench.lost_cycles([run])}")


def memory_claims(bench):
    low, apart = bench.lights(), at_voxel_steps(bench)
    of_four, paper = 6.4, 4.6  # GB/s: of four RDRAMs; in global illumination
    fog = bench.light("fog-box")
    fine, coarse = bench.get(fog.on({"asic.datapath": "wide"})), bench.get(fog.at_step(1))
    why = (f"the splats. Of 100 samples only {100 * bench.mean(low, deposits_a_sample):.1f} deposit, for most of a ray's way is empty and its "
           "energy of 8 bits has 255 units to give; a deposit is most often one unit, which goes to one voxel, and changes "
           f"{bench.mean(low, tiles_a_deposit):.1f} tiles in the mean. So most of the traffic is reads, as in rendering. That "
           f"{percent(bench.mean(low, tiles_combined))} of the changed tiles are written with an earlier change decides little: with a read and a "
           f"write for each the interface would be in use {percent(bench.mean(low, memory_use_uncombined))}. Where each sample deposits into all "
           f"eight voxels, in the fog box with energies of 24 bits, it is in use {percent(memory_use(fine))}, stands "
           f"{percent(memory_turnaround(fine))} of the time to turn from writes to reads and back, and the samples fall to "
           f"{samples_per_second(fine) * 1e-6:.0f} M/s. The sampling distance decides more: with voxel steps the fog box moves "
           f"{memory_gb_s(coarse):.1f} GB/s and uses {percent(memory_use(coarse))}. The paper's two rows don't agree: {paper:.1f} of the "
           f"{of_four:.1f} GB/s that four RDRAMs give are {percent(paper / of_four)}, not 92%")
    memory, use = bench.spread(low, memory_gb_s), bench.spread(low, memory_use)
    bench.page.claim(
        5, "memory bandwidth, global illumination; ours: the pass (3.3)", "4.6 GB/s",
        f"mean {memory.text(1, 1)} GB/s; {bench.spread(apart, memory_gb_s).text(1, 1)} with voxel steps", differs(memory.mean, 4.6), why)
    bench.page.claim(6, "memory interface in use, lighting pass (3.6)", "92%",
                     f"mean {use.text(0.01, 0)}%; {bench.spread(apart, memory_use).text(0.01, 0)}% with voxel steps", differs(use.mean, PAPER_USE),
                     "as row 5")


def light_sweep(bench, page):
    """Row 4, and what rows 2 and 6 depend on."""
    page.text("A residency is the time that a queue is the active one; a step is a sample or leap in it. Residencies of fewer than 32 steps are "
              "short: the pipeline is longer than that, so that no ray of them comes round.")
    rays_claim(bench, page)
    parameters(bench)


def rays_claim(bench, page):
    paper_pass, paper_rate = 361, 39  # ms, Hz
    counts = (1, 2, 3)  # rays a face voxel, k
    rows = []
    times = {"low albedo": [], "high albedo": [], "paper": len(counts) * [paper_pass]}
    for k in counts:
        passes = [bench.get(bench.light(BALL, k)), bench.get(bench.light(BALL, k, True))]
        rows.append([str(k), number(millions(passes[0], "dsp.lighting_rays"), 3)])
        for m, of_albedo in zip(passes, times.values()):
            of_albedo.append(frame_ms(m))
            rows[-1] += [number(frame_ms(m)), *cells(m, ["M samples/s", "memory in use"]),
                         percent(issued_in_short_residencies(m), 1), percent(m.clipped, 1)]
    page.chart("The number of lighting rays decides a pass's length.", "light-rays",
               "A lighting pass takes as long as it has rays (mirrored buckyball)", "rays a face voxel, k", "ms", counts, times)
    common = ["M samples/s", "memory in use", "steps in short residencies", "energy clipped"]
    page.table("light-rays-table", ["k", "low: M rays", "ms", *common, "high: ms", *common], rows)

    def nearest(high_albedo):
        return min(counts, key=lambda k: abs(frame_ms(bench.get(bench.light(BALL, k, high_albedo))) - paper_pass))

    low, high = nearest(False), nearest(True)
    low_ms, high_ms = frame_ms(bench.get(bench.light(BALL, low))), frame_ms(bench.get(bench.light(BALL, high, True)))
    run = bench.lit(BALL)
    frame, apart = bench.get(run), bench.get(run.at_step(1))
    page.claim(4, "buckyball on a mirror: illumination pass; later frames (4.1)", "361 ms; 39 Hz",
               f"{low_ms:.0f} ms with k = {low} (high albedo: {high_ms:.0f} ms with k = {high}); {rate_hz(frame):.1f} Hz, {rate_hz(apart):.1f} "
               "with voxel steps", differs(low_ms, paper_pass) or differs(rate_hz(frame), paper_rate),
               "k and the sampling distance, which the paper does not give, are the scene's length of work: a frame takes "
               f"{millions(frame, 'processor.samples'):.1f} M samples with half-voxel steps and {millions(apart, 'processor.samples'):.1f} M with "
               f"voxel steps, a pass {low_ms / low:.0f} ms a ray of each face voxel. Cycles of the frame without a sample: "
               f"{bench.lost_cycles([run])}")


def parameters(bench):
    variants = {"design point": {}}
    variants |= {f"{n} changed tiles wait": {"cache.write_packets": n} for n in (64, 1024)}
    variants |= {f"{n} DSP cycles a lighting ray": {"dsp.lighting_ray_cycles": n} for n in (15, 120)}
    variants |= {f"{n} compute stages": {"pipeline.compute_stages": n} for n in (4, 32)}
    variants |= {"queues of 1024 rays": {QUEUE: 1024}, "skewed blocks": SKEWED,
                 "skewed blocks, DSP 8 times as fast, wide links": SKEWED | FAST_DSP | WIDE_LINKS,
                 "wide datapath: energies of 24 bits": {"asic.datapath": "wide"}, "two processors share an RDRAM": SHARED_MEMORY,
                 "perfect memory": {"ideal.memory": 1}, "voxel steps": {}, "voxel steps, two processors share an RDRAM": SHARED_MEMORY}
    others = {"ms": lambda m: number(asic_ms(m)), "combined": lambda m: percent(tiles_combined(m)),
              "short residencies": lambda m: percent(issued_in_short_residencies(m), 1)}
    columns = ["ms", "M samples/s", "memory GB/s", "memory in use", "combined", "short residencies"]
    swept = [BALL, "fog-box"]
    rows, near_samples, near_use = [], [], []
    for name, settings in variants.items():
        rows.append([name])
        for scene in swept:
            m = bench.get(bench.light(scene).on(settings).at_step(1 if name.startswith("voxel steps") else 0.5))
            rows[-1] += cells(m, columns, others)
            if not differs(samples_per_second(m), PAPER_SAMPLES):
                near_samples.append(f"{name} ({scene})")
            if not differs(memory_use(m), PAPER_USE):
                near_use.append(f"{name} ({scene})")
    bench.page.text("Free parameters of a pass in low albedo with k = 1, one at a time:")
    bench.page.table("light-parameters", ["variant", *(f"{scene}: {column}" for scene in swept for column in columns)], rows)
    bench.page.text(f"Within a quarter of the paper's 122 M samples/s: {', '.join(near_samples) or 'none'}. Within a quarter of its 92% of the "
                    f"memory interface: {', '.join(near_use) or 'none'}.")


def tail_of(times):
    """From the first millisecond on after which none does half as many samples as the mean: its shares of time, samples and
    loads, 0..1."""
    samples, loads = sum(ms.samples for ms in times), sum(ms.loads for ms in times)
    half = 0.5 * ratio(samples, len(times))
    first = len(times)
    while first > 0 and times[first - 1].samples < half:
        first -= 1
    tail = times[first:]
    return (ratio(len(tail), len(times)), ratio(sum(ms.samples for ms in tail), samples), ratio(sum(ms.loads for ms in tail), loads))


def block_loads(bench, page):
    """Row 18."""
    for scene in (BALL, "fog-box"):
        times = milliseconds(bench.get(bench.light(scene)))
        series = {"block loads": [max(ms.loads, 1.0) for ms in times], "samples": [max(ms.samples, 1.0) for ms in times]}  # for the logarithm
        page.chart("A block load is a queue that becomes the active one.", f"block-loads-{scene}",
                   f"Figure 15: where few rays are under way blocks are loaded often ({scene}, lighting pass)", "ms", "in a millisecond",
                   range(len(times)), series, log_y=True)
    lengths = dict(zip(LIT_SCENES, bench.over(bench.lights(), residencies)))
    page.chart("Lighting passes, low albedo, k = 1.", "residencies", "Most steps are taken in long residencies of a queue",
               "steps of a residency, at least", "share of all steps", [each.steps for each in residencies(Measurement())],
               {scene: [each.issued for each in of_scene] for scene, of_scene in lengths.items()}, log_x=True)

    rows, tails, shorts = [], [], []
    for scene in LIT_SCENES:
        for part, run in (("pass", bench.light(scene)), ("frame", bench.lit(scene))):
            m = bench.get(run)
            loads = m["processor.sorter.activations"]
            short_loads = sum(each.activations for each in residencies(m) if each.steps < 32)
            time_share, sample_share, load_share = tail_of(milliseconds(m))
            short = issued_in_short_residencies(m)
            rows.append([scene, part, number(loads, 0), number(ratio(m["processor.sorter.issued"], loads)), percent(1 - short, 1),
                         percent(short_loads, 1), percent(time_share, 1), percent(sample_share, 2), percent(load_share, 1)])
            if part == "pass":
                tails.append(sample_share)
                shorts.append(short)
    page.text("Residencies and steps as in the section before. Tail: the milliseconds at the end in none of which half as many samples are taken "
              "as in the mean one.")
    page.table("block-loads", ["scene", "part", "block loads", "steps a load", "steps in residencies of 32 or more", "loads in short residencies",
                               "tail: share of time", "of samples", "of block loads"], rows)

    def short_with(settings):
        return percent(issued_in_short_residencies(bench.get(bench.light(BALL).on(settings))), 1)

    tail, short = mean_of(tails), mean_of(shorts)
    page.claim(18, "block loads in global illumination (5.1, Figure 15)", "99.6% of the computation in long queues, 0.4% thrash",
               f"{percent(1 - short, 1)} in residencies of 32 steps or more, {percent(short, 1)} in short ones; the tail at the end holds "
               f"{percent(tail, 2)} of the samples", differs(short, 0.004),
               "short residencies come not only at the end: a processor that gets few rays, since the light comes from one side and the DSP makes "
               f"one in 60 cycles, goes from queue to queue all the time. On the mirrored buckyball they hold {short_with({})} of the steps; "
               f"{short_with(SKEWED)} with skewed blocks, which spread the rays evenly, {short_with({'dsp.lighting_ray_cycles': 15})} with 15 DSP "
               f"cycles a ray, {short_with({QUEUE: 1024})} with queues of 1024 rays, {short_with({'pipeline.compute_stages': 4})} with a pipeline "
               f"of 4 compute stages. Lost cycles of all passes: {bench.lost_cycles(bench.lights())}")
