"""Energy of the paper's card on eight scenes, in pictures and in light, with RDRAM and with DDR, the joules of each
cause of lost cycles, and a card that gicube-explore found (energy_card.toml).

    PYTHONPATH=samples python3 -m studies.energy build/release/bin out    # writes out/energy.csv; keeps runs in out/

Resting joules are from a run with events at no cost; prices do not change simulated time. A lost cycle costs its share
of them."""
import functools
import os
import pathlib
import re
import subprocess
import sys

from studies.runs import Run, RunFolder, carry_out_all, progress
from studies.table import csv_text, write_whole

SCENES = ["builtin:buckyball", *(f"samples/scenes/{name}.scene" for name in (
    "fog_box", "glass", "golden_ring", "mirror_buckyball", "mirror_buckyball_area", "subsurface",
    "hypertexture/flame"))]
SMALL = ["--volume-size", "32", "--size", "64x64", "--set", "fidelity=cycle", "--threads", "1"]
MEMORY = ("memory", "memory_interface")
AGP = ["bus.model=agp2x"]
# chosen from the front: least time times energy, with no more on-chip memory and at most twice the transistors
CARD = [*AGP, "asic.block_voxels=16", "asic.queue_rays=64", "rdram.processors_per_rdram=2"]
KINDS = {"rdram": [], "rdram at rest": None, "ddr": ["memory=ddr"], "agp": AGP, "card": CARD}


def free_events(board):
    """Settings with events at no cost."""
    explained = subprocess.run([board, "--explain-config"], stdout=subprocess.PIPE, text=True, check=True).stdout
    return [f"{name}=0" for name in re.findall(r"^(energy\.\w+_(?:fj|aj)) ", explained,
                                               re.MULTILINE)] + ["energy.rdram_attention_uw=187500"]


def windows_of(statistics):
    """The frame, and all lighting passes together: (name, milliseconds, counters)."""
    def values(counters):
        return {name: each["value"] for name, each in counters.items()}
    yield "picture", statistics["frame_ms"], values(statistics["counters"])
    passes = [each for each in statistics["lighting"] or [] if not each["reused"]]
    if passes:
        names = {name for each in passes for name in each["counters"]}
        yield "light", sum(each["pass_ms"] for each in passes), {
            name: sum(each["counters"].get(name, {"value": 0})["value"] for each in passes) for name in names}


def causes_of(counters):
    """Share of each cause in the pipelines' cycles without a sample or a skipped block."""
    cycles = {name.removeprefix("processor.cycles."): value for name, value in counters.items()
              if name.startswith("processor.cycles.")}
    whole = sum(cycles.values())
    return {name: value / whole for name, value in cycles.items() if name not in ("busy", "leap") and value}


def rows_of(folder, runs):
    for scene in SCENES:
        found = {kind: list(windows_of(folder.read(runs[scene, kind]))) for kind in KINDS}
        for (what, ms, counters), (_, _, rest), (_, ddr_ms, ddr), *cards in zip(*(found[kind] for kind in KINDS)):
            def joules(name, of=counters):
                return of[f"energy.{name}"] * 1e-12
            causes = sorted(causes_of(counters).items(), key=lambda each: -each[1])
            lost = "; ".join(f"{name} {share * joules('total', rest) * 1e3:.3g}" for name, share in causes[:3])
            watts = joules("total") / ms * 1e3
            yield [pathlib.Path(scene.replace("builtin:", "")).stem, what, f"{ms:.3f}", f"{joules('total') * 1e3:.2f}",
                   f"{watts:.2f}",
                   f"{joules('total.low') / ms * 1e3:.2f}", f"{joules('total.high') / ms * 1e3:.2f}",
                   f"{joules('total', rest) * 1e3:.2f}",
                   f"{sum(map(joules, MEMORY)) * 1e3:.3f}", f"{ddr_ms:.3f}",
                   f"{sum(joules(part, ddr) for part in MEMORY) * 1e3:.3f}",
                   f"{joules('total', ddr) * 1e3:.2f}", lost,
                   *(text for _, card_ms, card in cards for text in (
                       f"{card_ms:.3f}", f"{joules('total', card) * 1e3:.2f}",
                       f"{joules('total', card) / card_ms * 1e3:.2f}"))]


COLUMNS = ["scene", "what", "ms", "mJ", "W", "low W", "high W", "resting mJ", "memory mJ", "DDR ms", "DDR memory mJ",
           "DDR mJ", "lost mJ", "AGP ms", "AGP mJ", "AGP W", "card ms", "card mJ", "card W"]


def main():
    programs, out = map(pathlib.Path, sys.argv[1:])
    folder = RunFolder(out)
    KINDS["rdram at rest"] = free_events(programs / "gicube-board")
    runs = {(scene, kind): Run([scene, *SMALL, *(word for field in fields for word in ("--set", field))])
            for scene in SCENES for kind, fields in KINDS.items()}
    carry_out_all(folder, list(runs.values()), str(programs / "gicube-render"), os.cpu_count(),
                  functools.partial(progress, "energy"))
    write_whole(out / "energy.csv", csv_text([COLUMNS, *rows_of(folder, runs)]))


if __name__ == "__main__":
    main()
