#!/usr/bin/python3
"""Measure the paper's results on emulated boards, and write RESULTS.md."""
import argparse
import functools
import os
import pathlib
import shutil
import sys

sys.dont_write_bytecode = True
PROGRAMS = pathlib.Path(__file__).absolute().parent  # the build links this file beside its programs
sys.path += [str(PROGRAMS.parent / "python"), str(pathlib.Path(__file__).resolve().parents[2])]
os.environ.setdefault("GICUBE_BOARD", str(PROGRAMS / "gicube-board"))

import gicube  # noqa: E402
from studies.sweep import shard_of  # noqa: E402

from bench import Bench  # noqa: E402
from measure import kept_in, measure_boards, measure_shard  # noqa: E402
from page import WORDS, Page, filled  # noqa: E402
from sections import design_point, light, memory, processors, scanline  # noqa: E402

SECTIONS = {  # by names for --only: heading, and the function of the section
    "scenes": ("Scenes at the design point", design_point.scenes),
    "bounds": ("Bounds, and where the cycles go", design_point.bounds),
    "baseline": ("Reordering against scanline order", scanline.baseline),
    "illumination": ("Global illumination", light.illumination),
    "light-sweep": ("What decides a lighting pass", light.light_sweep),
    "block-loads": ("Block loads", light.block_loads),
    "lit-baseline": ("Reordering against scanline order in global illumination", scanline.lit_baseline),
    "partition": ("Partitions, links and load balance", processors.partition),
    "gains": ("Space leaping, early termination, VolumePro", design_point.gains),
    "speed-up": ("Scaling", processors.speed_up),
    "scaling": ("", processors.scaling),
    "cache": ("Blocks and queues", memory.cache),
    "sampling": ("Sampling distance and image size", memory.sampling),
    "bus": ("Host bus", design_point.bus),
    "cost": ("Hardware cost", design_point.cost),
    "parameters": ("Free parameters", design_point.parameters)}


def sections_of(text):
    if unknown := set(text.split(",")) - set(SECTIONS):
        raise argparse.ArgumentTypeError(f"{unknown.pop()} is none of {', '.join(SECTIONS)}")
    return text.split(",")


def folder_of(text):
    if not pathlib.Path(text).is_dir():
        raise argparse.ArgumentTypeError(f"{text} is no folder")
    return pathlib.Path(text)


def number_of(text, low, high):
    if not low <= int(text) <= high:
        raise argparse.ArgumentTypeError(f"{text} is not in {low} to {high}")
    return int(text)


def options():
    parser = argparse.ArgumentParser(prog="gicube-results", description=__doc__)
    parser.add_argument("folder", metavar="FOLDER", type=folder_of,
                        help="write RESULTS.md here, and its CSV files and pictures in results/; measured/ keeps "
                             "measurements, so that an interrupted run continues")
    parser.add_argument("--version", action="version", version=f"%(prog)s {gicube.__version__}")
    parser.add_argument("--edge", type=int, choices=(32, 64, 128, 256), default=256,
                        help="edge of the volume, voxels (%(default)s)")
    parser.add_argument("--image", type=functools.partial(number_of, low=8, high=1024), default=256,
                        help="edge of the image, 8 to 1024 pixels (%(default)s)")
    parser.add_argument("--jobs", type=functools.partial(number_of, low=1, high=64), default=os.cpu_count(),
                        help="number of parallel boards, 1 to 64 (%(default)s)")
    parser.add_argument("--only", type=sections_of, default=list(SECTIONS), metavar="SECTION,...",
                        help="measure only these sections, for a page of these (all)")
    parser.add_argument("--shard", type=shard_of, metavar="I/N",
                        help="measure only this one of N parts of the boards, 1/N to N/N, and write no page; the same "
                             "command without --shard writes it from the shards' measured/ and results/")
    parser.add_argument("--quiet", action="store_true", help="print no progress")
    return parser


def main():
    given = options().parse_args()
    folder = given.folder / "results"
    folder.mkdir(exist_ok=True)
    bench = Bench(given.edge, given.image)
    measured = given.folder / "measured"
    pictures = {run: folder / f"scene-{run.scene}.png" for run in bench.oblique() + bench.lit_scenes()}
    kept = kept_in(measured)
    measure = functools.partial(measure_boards, kept, given.jobs, pictures)
    if given.shard:
        measure = functools.partial(measure_shard, kept, given.shard, measure)
    while True:
        bench.page = Page()
        for name, (heading, section) in SECTIONS.items():
            if name in given.only:
                bench.page.heading(heading)
                section(bench, bench.page)
        if bench.complete():
            break
        if not bench.measure(measure, given.quiet):
            if not given.quiet:
                print("gicube-results: this shard's part is done. What is left depends on other shards' parts: once "
                      "these are done too, the same "
                      "command measures it")
            return
    if given.shard:
        return
    introduction = filled(WORDS["introduction"].format(edge=bench.edge, block=bench.block, image=bench.image,
                                                       **bench.page.rows_within()))
    (given.folder / "RESULTS.md").write_text(
        f"{introduction}\n\n## Paper and ours\n\n{bench.page.claims()}{bench.page.body}")
    bench.page.write_files(folder)
    shutil.rmtree(measured)


try:
    main()
except (OSError, RuntimeError, ValueError) as error:
    sys.exit(f"gicube-results: {error}")
