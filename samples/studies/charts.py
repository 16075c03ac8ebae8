"""Measures and draws the charts of docs/studies/charts on emulated boards: CSV and SVG. All charts take hours, the cone
beam's most. build/charts keeps finished runs, so the same command continues an interrupted one.

Names: """
import argparse
import functools
import importlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from studies import levels, plots
from studies.points import BIN, ROOT, Kept, measure, text_of
from studies.table import pareto

TESTS = ROOT / "build/release/tests"
RUNS = ROOT / "build/charts"
CHARTS = ROOT / "docs/studies/charts"


def build(*targets):
    subprocess.run(["cmake", "--build", "--preset", "release", "--target", "gicube-board", *targets], cwd=ROOT,
                   check=True)


def run(program, *arguments):
    subprocess.run([program, *map(str, arguments)], cwd=ROOT, check=True)


def tables_of(name):
    """Measures charts of points."""
    build("gicube_python", *POINTS[name])
    return importlib.import_module(f"studies.{name}").tables()


def sources_of(name):
    """The module of a study, or the modules of its folder."""
    folder = ROOT / "samples/studies" / name
    return sorted(folder.glob("*.py")) if folder.is_dir() else [folder.with_suffix(".py")]


def by_points(name, jobs):
    tables = tables_of(name)
    programs = [next(folder / program for folder in (BIN, TESTS) if (folder / program).exists())
                for program in ("gicube-board", *POINTS[name])] + sources_of(name)
    measure(tables, Kept(RUNS / name, programs), CHARTS, jobs)
    if name == "cone_beam":
        # The double-precision reference belongs to the tests, so a bench measures the trade with it.
        build("gicube_bench")
        trade = CHARTS / "cone_beam_trade.csv"
        run(TESTS / "gicube_bench", "--benchmark_filter=cone_beam_trade", f"--benchmark_out={trade}",
            "--benchmark_out_format=csv")
        written = trade.read_text()
        # without Google Benchmark's text about the machine
        trade.write_text(written[written.index("name,iterations"):])
    elif name == "form_factors":
        pareto(CHARTS / "form_factors_front.csv", [CHARTS / "form_factors_trade.csv"], error="error",
               costs=["board_ms", "bus_ms"], per="pairs",
               series=("bus", "made"))
    shutil.rmtree(RUNS / name)


def print_point(name):
    for chart in POINTS:
        for table in tables_of(chart):
            if name in table.points:
                with tempfile.TemporaryDirectory() as folder:
                    print(text_of(table, [(name, table.points[name](Kept(folder)))]), end="")
                return
    sys.exit(f'script/charts: --point: expected a point of a table, as views/fdk/20, got "{name}"')


def swept(folder, name, *arguments):
    """Runs a sweep of gicube-render into the charts' folder."""
    run(BIN / "gicube-sweep", *arguments, "--name", name, "-o", RUNS / folder)
    shutil.copy(RUNS / folder / f"{name}.csv", CHARTS)


def each(option, *values):
    return [word for value in values for word in (option, value)]


def rendering(jobs):
    build("gicube-render", "gicube-reference")
    exact = RUNS / "buckyball.exr"
    if not exact.exists():
        RUNS.mkdir(parents=True, exist_ok=True)
        run(TESTS / "gicube-reference", "builtin:buckyball", "--volume-size", 128, "--size", "256x256", "--step",
            0.0625, "--threshold", 1,
            "-o", exact)
    swept("rendering", "rendering", "builtin:buckyball", *each("--fix", "volume-size=128", "fidelity=cycle"),
          *each("--vary", "step=0.25,0.5,1,2", "jitter=off,on", "threshold=0.9,0.98,1", "size=128x128,192x192,256x256",
                "level-of-detail=0,1", "asic.datapath=paper,wide"),
          "--reference-picture", exact, *each("--also", "bus_ms", "samples"), "--jobs", jobs)


def levels_of_pairs(_):
    """The cost is the host's seconds: one run at a time, and new runs after the last are done."""
    build("gicube-render", "gicube-cone-beam")
    levels.measure(ROOT / "samples/studies/level_pairs.txt", RUNS / "levels", BIN, CHARTS / "levels.csv")
    shutil.rmtree(RUNS / "levels")


POINTS = {"lighting": [], "light": ["gicube-render", "gicube-light", "gicube-light-reference"],
          "cone_beam": ["gicube-cone-beam"], "form_factors": ["gicube-form-factors"],
          "volume_texture": ["gicube-compose"],
          "boards": ["gicube-render"], "truths": ["gicube-light"]}  # programs of the points
MEASURED = {"rendering": rendering, **{name: functools.partial(by_points, name) for name in POINTS},
            "levels": levels_of_pairs}


def main():
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parser = argparse.ArgumentParser(prog="script/charts", description=__doc__ + ", ".join(MEASURED) + ".")
    parser.add_argument("names", nargs="*", metavar="NAME", help="charts to measure (all)")
    parser.add_argument("--jobs", type=int, default=0,
                        help="number of parallel runs if seconds are not measured; 0: one per core (%(default)s)")
    parser.add_argument("--point", help="measure the point of this name in the tables again, and print its row")
    parser.add_argument("--draw", action="store_true", help="draw charts from existing tables, without measuring")
    given = parser.parse_args()
    for name in given.names:
        if name not in MEASURED:
            parser.error(f'expected {", ".join(MEASURED)}, got "{name}"')
    os.chdir(ROOT)
    sys.path.insert(1, str(ROOT / "build/release/python"))  # the package gicube
    os.environ["GICUBE_BOARD"] = str(BIN / "gicube-board")
    if given.point:
        return print_point(given.point)
    CHARTS.mkdir(parents=True, exist_ok=True)
    names = given.names or list(MEASURED)
    for number, name in enumerate(names, 1):
        start = time.monotonic()
        if not given.draw:
            print(f"charts: {number} of {len(names)}: {name}", flush=True)
            MEASURED[name](given.jobs)
        for draw in plots.DRAWN[name]:
            draw(CHARTS)
        print(f"charts: {CHARTS}/{name}*, {time.monotonic() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
