"""The paper's board: its scenes and their bounds, its free parameters, its bus and its hardware cost."""
import os

from bench import CELLS, IDEAL_DSP, SCENES, SHARED_MEMORY, at_paper, cells
from figures import (asic_ms, balance_held, dsp_use, frame_ms, hit_ratio, memory_gb_s, memory_use, rate_hz, ratio,
                     rays_sent, samples_per_second, spread_of, throughput, to_ms)
from page import WORDS, differs, number, percent
from studies.hardware_cost import hardware_cost

REAL_TIME = 30  # Hz
LOGIC = {"Queues": 2, "Volume cache": 2, "Pipeline": 4, "Control": 1.5, "All parts": 9.5}  # M transistors [P Table 1]


def scenes(bench, page):
    """Rows 2, 5, 6 and 23."""
    about = []
    for run in bench.oblique():
        m = bench.get(run)
        about.append([run.scene, SCENES[run.scene], "yes" if m["pipeline.leaps"] > 0 else "none",
                      percent(ratio(m["pipeline.visible_samples"], m["pipeline.samples"]))])
        page.picture(f"scene-{run.scene}.png", run.scene)
    page.table("scenes", ["scene", "what it is there for", "blocks without anything visible",
                          "samples that show something"], about)
    page.say("scenes")
    others = {"M samples": lambda m: number(m["processor.samples"] * 1e-6, 2),
              "rays sent /100 cycles": lambda m: number(rays_sent(m), 2),
              "balance": lambda m: percent(balance_held(m))}
    columns = ["frame ms", "Hz", "ASIC ms", "M samples", "M samples/s", "throughput", "memory GB/s", "memory in use",
               "hit ratio",
               "rays sent /100 cycles", "balance", "DSP busy", "overflows a ray"]
    page.table("design-point", ["scene", "view", *columns],
               [[run.scene, run.view, *cells(bench.get(run), columns, others)] for run in bench.all()])
    memory_claims(bench, page)
    rate_claim(bench, page)


def memory_claims(bench, page):
    ours, half = ([bench.spread(runs, figure) for figure in (memory_gb_s, memory_use, samples_per_second)]
                  for runs in (at_paper(bench.all()), bench.all()))
    (memory, use, samples), (half_memory, half_use, half_samples) = ours, half
    page.claim("2 rendering", differs(samples.mean, 231e6), samples=samples.text(1e6, 0),
               half_samples=half_samples.text(1e6, 0))
    figures = {"paper_bytes": 2.8e9 / 231e6, "bytes": ratio(memory.mean * 1e9, samples.mean),
               "half_bytes": ratio(half_memory.mean * 1e9, half_samples.mean),
               "oblique": bench.mean(at_paper(bench.oblique()), memory_gb_s),
               "oblique_use": bench.mean(at_paper(bench.oblique()), memory_use)}
    page.claim("5 rendering", differs(memory.mean, 2.8), memory=memory.text(1, 1), half_memory=half_memory.text(1, 1),
               **figures)
    page.claim("6 rendering", differs(use.mean, 0.375), use=use.text(0.01, 0), half_use=half_use.text(0.01, 0),
               **figures)


def rate_claim(bench, page):
    rate, half = bench.spread(at_paper(bench.oblique()), rate_hz), bench.spread(bench.oblique(), rate_hz)
    slow = []
    for run in at_paper(bench.oblique()):
        m = bench.get(run)
        samples = m["processor.samples"]
        if rate_hz(m) < REAL_TIME:
            slow.append(WORDS["row 23 slow"].format(
                scene=run.scene, samples=samples * 1e-6, alone=ratio(samples, m.processors * m.core_hz) * 1e3,
                bus=frame_ms(m) - asic_ms(m)))
    scanned = f"; {names_of(bench.scans())} {bench.spread(bench.scans(), rate_hz).text(1, 1)}" if bench.scans() else ""
    page.claim(23, differs(min(rate.min, REAL_TIME), REAL_TIME), rate=rate.text(1, 1), scanned=scanned,
               half=half.text(1, 1), slow="; ".join(slow))


def names_of(scans):
    return f"scans ({', '.join(run.scene for run in scans)})"


def bounds(bench, page):
    """Causes of the time."""
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
    page.table("bounds", ["scene", "as it is, ms", "perfect memory", "perfect queues", "perfect sorter", "all three",
                          "sharing an RDRAM"], rows)
    page.say("causes")
    bench.causes_table("causes", SCENES, bench.oblique())


def gains(bench, page):
    """Rows 11 and 20."""
    volume_pro = 301e6  # samples per second at 100 MHz [P §5.1]
    page.say("gains")
    (leap, end, worth), rows = gains_of(bench, at_paper(bench.all()))
    (half_leap, half_end, half_worth), half_rows = gains_of(bench, bench.all())
    columns = ["scene", "view", "ms", "without leaps", "gain", "without termination", "gain", "M samples/s",
               "worth, M samples/s"]
    scans = bench.scans()
    (scan_leap, scan_end, _), scan_rows = gains_of(bench, scans)
    page.table("gains", ["steps", *columns],
               [[steps, *row] for steps, of_steps in (("paper", rows + scan_rows), ("half", half_rows))
                for row in of_steps])

    def text(leap, end):
        return f"{leap.min:.0f} / {leap.mean:.0f} / {leap.max:.0f}%; {end.min:.0f} / {end.mean:.0f} / {end.max:.0f}%"

    def most(column):
        best = max(rows, key=lambda row: float(row[column].rstrip("%")))
        return f"{best[0]}, {best[1]}"

    leap, end = leap.times(100), end.times(100)
    page.claim(11, differs(leap.mean, 21) or differs(leap.max, 34) or differs(end.mean, 12) or differs(end.max, 24),
               gains=text(leap, end),
               scanned=f"; {names_of(scans)} {text(scan_leap.times(100), scan_end.times(100))}" if scans else "",
               half=text(half_leap.times(100), half_end.times(100)), most_leaps=most(4), most_ends=most(6))
    page.claim(20, worth.mean < volume_pro, worth=worth.text(1e6, 0), half=half_worth.text(1e6, 0))


def gains_of(bench, runs):
    """Gains by skipping and termination (shares), the equivalent rate, and a table row per run."""
    rows, leaps, ends, worths = [], [], [], []
    for run in runs:
        both, no_leaps = bench.get(run), bench.get(run.but(leap=False))
        no_end, neither = bench.get(run.but(faint=True)), bench.get(run.but(faint=True, leap=False))
        leaps.append(ratio(asic_ms(no_leaps), asic_ms(both)) - 1)
        ends.append(ratio(asic_ms(no_end), asic_ms(both)) - 1)
        worths.append(ratio(neither["processor.samples"], asic_ms(both) * 1e-3))
        rows.append([run.scene, run.view, number(asic_ms(both)), number(asic_ms(no_leaps)), percent(leaps[-1]),
                     number(asic_ms(no_end)), percent(ends[-1]), CELLS["M samples/s"](both),
                     number(worths[-1] * 1e-6, 0)])
    return list(map(spread_of, (leaps, ends, worths))), rows


def parameters(bench, page):
    """Free parameters."""
    paper = 231e6 / 400e6  # throughput [P §5.1]
    variants = {"design point": {}}
    for prefetch, compute in ((4, 28), (8, 24), (24, 8), (28, 4), (16, 48), (48, 16)):
        variants[f"pipeline split {prefetch} + {compute}"] = {"pipeline.prefetch_stages": prefetch,
            "pipeline.compute_stages": compute}
    variants |= {f"{n} packets asked for at a time": {"cache.miss_packets": n} for n in (8, 16, 64, 256)}
    variants |= {f"cache of {n} ways": {"cache.ways": n} for n in (2, 4, 8)}
    variants |= {"cache banks of two ports": {"cache.ports": 2}, "tags of voxels": {"cache.tags": "of_voxels"}}
    variants |= {f"DSP of {mhz} MHz": {"dsp.clock_khz": 1000 * mhz}
                 for mhz in (50, 100, 400)} | {"ideal DSP": IDEAL_DSP}
    variants |= {f"runs of {n} rays": {"dsp.run_rays": n} for n in (4, 16, 64, 256)}
    variants |= {f"{n} rays under way": {"dsp.overflow_rays": n} for n in (1024, 2048)}
    variants["queues by contribution"] = {"sorter.policy": "most_contribution"}

    page.say("parameters")
    swept = ["buckyball", "head", "rock"]
    rows, far = [], []
    for name, settings in variants.items():
        runs = [bench.run(scene).on(settings) for scene in swept]
        busy = bench.mean(runs, throughput)
        rows.append([name, *(number(asic_ms(bench.get(run)), 2) for run in runs), percent(busy, 1),
                     percent(bench.mean(runs, hit_ratio), 1),
                     number(bench.mean(runs, memory_gb_s), 2), percent(bench.mean(runs, dsp_use))])
        if differs(busy, paper):
            far.append(f"{name} ({percent(busy)})")
    page.table("parameters", ["variant", *swept, "throughput, mean", "hit ratio, mean", "memory GB/s, mean",
                              "DSP busy, mean"], rows)
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
        rows.append([name, number(image_ms, 2), percent(share[name]), str(rays["dsp.host_rays"]),
                     number(rays["bus.rays.bytes"] * 1e-6, 1),
                     number(rays_ms, 1), number(ratio(1e3, rays_ms)), number(frame_ms(rays), 1), number(rate_hz(rays))])
    page.say("bus", size=design.width)
    page.table("bus", ["bus", "image, ms", f"share of the bus at {REAL_TIME} Hz", "host's rays", "MB down and up",
                       "bus ms for them", "at most Hz", "there and back, ms", "Hz"], rows)
    pci, agp = rate["pci33"], rate["agp2x"]
    page.claim(21, share["pci33"] > 1 or pci > REAL_TIME or agp < pci, share=share["pci33"], pci=pci, agp=agp)


def cost(bench, page):
    """Row 22."""
    built = hardware_cost(os.environ["GICUBE_BOARD"])
    items, parts = built.items, built.parts
    page.say("cost")
    page.table("hardware-cost", ["item", "bits", "total"],
               [[name, formula, total] for name, formula, _, total in items])
    page.say("logic")
    page.table("hardware-logic", ["part", "paper, M transistors", "ours"],
               [[name, str(LOGIC[name]), millions] for name, millions in parts])
    megabits = {name: int(bits) / (1 << 20) for name, _, bits, _ in items}
    edram, sram, logic = megabits["Total eDRAM"], megabits["Total SRAM"], dict(parts)
    page.claim(22, differs(edram, 32) or differs(sram, 15)
               or any(differs(float(logic[name]), of_paper) for name, of_paper in LOGIC.items()),
               edram=edram, sram=sram, logic=logic["All parts"])
