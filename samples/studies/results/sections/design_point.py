"""The board of the paper as it is: its scenes, what bounds them, its free parameters, its bus and its hardware cost."""
import os
import re
import subprocess

from bench import CELLS, SCENES, SHARED_MEMORY, cells
from figures import (asic_ms, balance_held, dsp_use, frame_ms, hit_ratio, memory_gb_s, memory_use, rate_hz, ratio,
                     rays_sent, samples_per_second, spread_of, throughput, to_ms)
from page import WORDS, differs, number, percent

REAL_TIME = 30  # Hz


def scenes(bench, page):
    """Rows 2, 5, 6 and 23."""
    about = []
    for run in bench.oblique():
        m = bench.get(run)
        about.append([run.scene, SCENES[run.scene], "yes" if m["pipeline.leaps"] > 0 else "none",
                      percent(ratio(m["pipeline.visible_samples"], m["pipeline.samples"]))])
        page.picture(f"scene-{run.scene}.png", run.scene)
    page.table("scenes", ["scene", "what it is there for", "blocks without anything visible", "samples that show something"], about)
    page.say("scenes")
    others = {"M samples": lambda m: number(m["processor.samples"] * 1e-6, 2), "rays sent /100 cycles": lambda m: number(rays_sent(m), 2),
              "balance": lambda m: percent(balance_held(m))}
    columns = ["frame ms", "Hz", "ASIC ms", "M samples", "M samples/s", "throughput", "memory GB/s", "memory in use", "hit ratio",
               "rays sent /100 cycles", "balance", "DSP busy", "overflows a ray"]
    page.table("design-point", ["scene", "view", *columns], [[run.scene, run.view, *cells(bench.get(run), columns, others)] for run in bench.all()])
    memory_claims(bench, page)
    rate_claim(bench, page)


def memory_claims(bench, page):
    memory, use, samples = (bench.spread(bench.all(), figure) for figure in (memory_gb_s, memory_use, samples_per_second))
    # Oblique views with samples a voxel apart, with the paper's jitter [P §2.1] half to a whole voxel.
    jittered = [run.at_step(1).but(jitter=True) for run in bench.oblique()]
    apart = [run.at_step(1) for run in bench.oblique()]
    page.claim("2 rendering", differs(samples.mean, 231e6), samples=samples.text(1e6, 0))
    figures = {"jittered": bench.mean(jittered, memory_gb_s), "jittered_use": bench.mean(jittered, memory_use),
               "paper_bytes": 2.8e9 / 231e6, "bytes": ratio(memory.mean * 1e9, samples.mean), "oblique": bench.mean(bench.oblique(), memory_gb_s),
               "apart": bench.mean(apart, memory_gb_s), "apart_use": bench.mean(apart, memory_use)}
    page.claim("5 rendering", differs(memory.mean, 2.8), memory=memory.text(1, 1), **figures)
    page.claim("6 rendering", differs(use.mean, 0.375), use=use.text(0.01, 0), **figures)


def rate_claim(bench, page):
    rate = bench.spread(bench.oblique(), rate_hz)
    slow = []
    for run in bench.oblique():
        m = bench.get(run)
        samples = m["processor.samples"]
        if rate_hz(m) < REAL_TIME:
            slow.append(WORDS["row 23 slow"].format(
                scene=run.scene, samples=samples * 1e-6, alone=ratio(samples, m.processors * m.core_hz) * 1e3, bus=frame_ms(m) - asic_ms(m),
                apart=rate_hz(bench.get(run.at_step(1)))))
    page.claim(23, rate.min < REAL_TIME, rate=rate.text(1, 1), slow="; ".join(slow))


def bounds(bench, page):
    """Where the time goes."""
    page.say("bounds")
    ideals = [{f"ideal.{part}": 1} for part in ("memory", "queues", "sorter")]
    rows = []
    for run in bench.oblique():
        own = asic_ms(bench.get(run))
        row = [run.scene, number(own)]
        for settings in [*ideals, ideals[0] | ideals[1] | ideals[2], SHARED_MEMORY]:
            bound = asic_ms(bench.get(run.on(settings)))
            row.append(f"{bound:.1f} ({100 * (ratio(bound, own) - 1):+.0f}%)")
        rows.append(row)
    page.table("bounds", ["scene", "as it is, ms", "perfect memory", "perfect queues", "perfect sorter", "all three", "sharing an RDRAM"], rows)
    page.say("causes")
    bench.causes_table("causes", SCENES, bench.oblique())


def gains(bench, page):
    """Rows 11 and 20."""
    volume_pro = 301e6  # samples a second at 100 MHz [P §5.1]
    page.say("gains")
    rows, leaps, ends, worths = [], [], [], []
    for run in bench.all():
        both, no_leaps = bench.get(run), bench.get(run.but(leap=False))
        no_end, neither = bench.get(run.but(faint=True)), bench.get(run.but(faint=True, leap=False))
        leaps.append(ratio(asic_ms(no_leaps), asic_ms(both)) - 1)
        ends.append(ratio(asic_ms(no_end), asic_ms(both)) - 1)
        worths.append(ratio(neither["processor.samples"], asic_ms(both) * 1e-3))
        rows.append([run.scene, run.view, number(asic_ms(both)), number(asic_ms(no_leaps)), percent(leaps[-1]),
                     number(asic_ms(no_end)), percent(ends[-1]), CELLS["M samples/s"](both), number(worths[-1] * 1e-6, 0)])
    page.table("gains", ["scene", "view", "ms", "without leaps", "gain", "without termination", "gain", "M samples/s", "worth, M samples/s"], rows)

    def view_of_max(values):
        run = bench.all()[values.index(max(values))]
        return f"{run.scene}, {run.view}"

    leap, end, worth = spread_of(leaps), spread_of(ends), spread_of(worths)
    page.claim(11, differs(leap.mean, 0.21) or differs(leap.max, 0.34) or differs(end.mean, 0.12) or differs(end.max, 0.24),
               leap=leap.times(100), end=end.times(100), most_leaps=view_of_max(leaps), most_ends=view_of_max(ends))
    page.claim(20, worth.mean < volume_pro, worth=f"{worth.mean * 1e-6:.0f} M ({worth.min * 1e-6:.0f} to {worth.max * 1e-6:.0f})")


def parameters(bench, page):
    """Free parameters."""
    paper = 231e6 / 400e6  # throughput [P §5.1]
    variants = {"design point": {}}
    for prefetch, compute in ((4, 28), (8, 24), (24, 8), (28, 4), (16, 48), (48, 16)):
        variants[f"pipeline split {prefetch} + {compute}"] = {"pipeline.prefetch_stages": prefetch, "pipeline.compute_stages": compute}
    variants |= {f"{n} packets asked for at a time": {"cache.miss_packets": n} for n in (8, 16, 64, 256)}
    variants |= {f"cache of {n} ways": {"cache.ways": n} for n in (2, 4, 8)}
    variants |= {f"DSP of {mhz} MHz": {"dsp.clock_khz": 1000 * mhz} for mhz in (50, 100, 400, 800)}
    variants |= {f"runs of {n} rays": {"dsp.run_rays": n} for n in (4, 16, 64, 256)}
    variants["queues by contribution"] = {"sorter.policy": "most_contribution"}

    page.say("parameters")
    swept = ["buckyball", "head", "rock"]
    rows, far = [], []
    for name, settings in variants.items():
        runs = [bench.run(scene).on(settings) for scene in swept]
        busy = bench.mean(runs, throughput)
        rows.append([name, *(number(asic_ms(bench.get(run)), 2) for run in runs), percent(busy, 1), percent(bench.mean(runs, hit_ratio), 1),
                     number(bench.mean(runs, memory_gb_s), 2), percent(bench.mean(runs, dsp_use))])
        if differs(busy, paper):
            far.append(f"{name} ({percent(busy)})")
    page.table("parameters", ["variant", *swept, "throughput, mean", "hit ratio, mean", "memory GB/s, mean", "DSP busy, mean"], rows)
    page.say("parameters within", paper=paper, far=f" but {', '.join(far)}" if far else "")


def bus(bench, page):
    """Row 21."""
    design = bench.run("buckyball").but(width=2 * bench.image, height=2 * bench.image)
    rows, share, rate = [], {}, {}
    for name in ("pci33", "agp1x", "agp2x", "agp4x"):
        run = design if name == "pci33" else design.on({"bus.model": name})
        image, rays = bench.get(run), bench.get(run.but(kind="host_rays"))
        image_ms = to_ms(image["bus.image.time_ps"])
        rays_ms = to_ms(rays["bus.down.busy_ps"] + rays["bus.up.busy_ps"])
        share[name], rate[name] = image_ms * REAL_TIME * 1e-3, rate_hz(rays)
        rows.append([name, number(image_ms, 2), percent(share[name]), str(rays["dsp.host_rays"]), number(rays["bus.rays.bytes"] * 1e-6, 1),
                     number(rays_ms, 1), number(ratio(1e3, rays_ms)), number(frame_ms(rays), 1), number(rate_hz(rays))])
    page.say("bus", size=design.width)
    page.table("bus", ["bus", "image, ms", f"share of the bus at {REAL_TIME} Hz", "host's rays", "MB down and up",
                       "bus ms for them", "at most Hz", "there and back, ms", "Hz"], rows)
    pci, agp = rate["pci33"], rate["agp2x"]
    page.claim(21, share["pci33"] > 1 or pci > REAL_TIME or agp < pci, share=share["pci33"], pci=pci, agp=agp)


def cost(bench, page):
    """Row 22."""
    program = os.environ["GICUBE_BOARD"]
    text = subprocess.run([program, "--hardware-cost"], stdout=subprocess.PIPE, text=True).stdout
    # Lines "NAME   FORMULA   BITS bit   3.0 Mb SRAM".
    items = re.findall(r"^(\S.*?)  +(\S.*?)? +(\d+) bit +(.+)$", text, re.MULTILINE)
    if not items:
        raise RuntimeError(f"{program} --hardware-cost: no table")
    page.say("cost")
    page.table("hardware-cost", ["item", "bits", "total"], [[name, formula, total] for name, formula, _, total in items])
    megabits = {name: int(bits) / (1 << 20) for name, _, bits, _ in items}
    edram, sram = megabits["Total eDRAM"], megabits["Total SRAM"]
    page.claim(22, differs(edram, 32) or differs(sram, 15), edram=edram, sram=sram)
