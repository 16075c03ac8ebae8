"""Tables of points, measured in parallel. Files keep the results, so that an interrupted table continues; the name of a
point makes its row again."""
import functools
import hashlib
import json
import pathlib
import threading
from collections import defaultdict
from typing import Callable, NamedTuple

from studies.runs import all_at_once, progress, run_to_end
from studies.table import csv_text, write_whole

ROOT = pathlib.Path(__file__).resolve().parents[2]
BIN = ROOT / "build/release/bin"


class Table(NamedTuple):
    name: str  # of its file, NAME.csv
    columns: list  # without the command that makes a row again
    points: dict  # by name: a function of a Kept that returns the measurement
    rows: Callable  # converts a list of (name, measurement) to a list of (name, cells)
    again: bool = True  # whether the last column has that command


class Kept:
    """Results in JSON files, each made once. A second request for a result waits for the first. Results of other
    `programs` than these are ignored."""

    def __init__(self, folder, programs=()):
        self._folder = pathlib.Path(folder) / short_hash(b"".join(pathlib.Path(each).read_bytes() for each in programs))
        self._folder.mkdir(parents=True, exist_ok=True)
        self._locks = defaultdict(threading.Lock)

    def _file(self, name):
        return self._folder / f"{short_hash(name.encode())}.json"

    def has(self, name):
        return self._file(name).exists()

    def forget(self, name):
        self._file(name).unlink(missing_ok=True)

    def of(self, name, make):
        file = self._file(name)
        with self._locks[name]:
            if not file.exists():
                write_whole(file, json.dumps(make()))
        return json.loads(file.read_text())


def short_hash(data):
    return hashlib.sha256(data).hexdigest()[:16]


def run(folder, program, words):
    """Runs a program of the build; blanks separate the words, and @ names files in FOLDER."""
    run_to_end(BIN / program, words.replace("@", f"{folder}/").split(), folder / "log")


def statistics(file):
    return json.loads(file.read_text())


def measure(tables, kept, folder, jobs=0):
    """Writes the tables into a folder, with `jobs` parallel points (0: one per core). Raises what the points raise."""
    points = {name: make for table in tables for name, make in table.points.items()}
    left = {name: make for name, make in points.items() if not kept.has(name)}
    if len(left) < len(points):
        print(f"charts: {len(points) - len(left)} of {len(points)} points are there", flush=True)
    with progress("charts", len(left)) as bar:
        for _ in all_at_once([functools.partial(kept.of, name, functools.partial(make, kept)) for name,
                              make in left.items()], jobs):
            bar.update()
    for table in tables:
        found = [(name, kept.of(name, None)) for name in table.points]
        write_whole(folder / f"{table.name}.csv", text_of(table, found))


def text_of(table, found):
    rows = [[*cells, f"script/charts --point {name}"] if table.again else cells for name, cells in table.rows(found)]
    return csv_text([[*table.columns, *["command"] * table.again], *rows])
