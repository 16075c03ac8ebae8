"""Runs of gicube-render: their commands, output files, and results."""
import concurrent.futures
import functools
import hashlib
import json
import math
import os
import pathlib
import shlex
import subprocess
import sys
import threading

from tqdm import tqdm

from studies.table import FileError


class RunFailed(Exception):
    """A program ended with an exit code other than 0."""


class InputError(Exception):
    """A value of the user or of a file is not as expected."""

    def __init__(self, what, expected, got):
        super().__init__(f"{what}: expected {expected}, got {got}")


def quoted(argument):
    """The command for a POSIX shell."""
    return shlex.quote(argument).replace("'\"'\"'", "'\\''")


def is_field(name):
    """Whether a parameter is a field of the board's configuration; others are options of gicube-render."""
    return "." in name or name == "memory"


def run_to_end(program, arguments, log):
    """Runs the command with its output in the file `log`. Raises RunFailed, with its exit code and its last line,
    unless that is 0."""
    try:
        with open(log, "wb") as stream:
            code = subprocess.run([program, *arguments], stdin=subprocess.DEVNULL, stdout=stream,
                                  stderr=subprocess.STDOUT).returncode
    except OSError as error:
        raise RunFailed(f"{program}: {os.strerror(error.errno)}") from error
    if code < 0:
        raise RunFailed(f"ended by signal {-code}")
    if code > 0:
        lines = [line for line in pathlib.Path(log).read_text(errors="replace").splitlines() if line]
        raise RunFailed(f"exit code {code}: {lines[-1] if lines else 'it wrote nothing'}")


class Run:
    """Arguments of gicube-render, without its output and statistics."""

    def __init__(self, arguments):
        self.arguments = list(arguments)

    def key(self):
        """Name of the run in its folder: the same for equal arguments and unchanged input and checkpoint files."""
        names = self.arguments[:1] + [after for option,
                                      after in zip(self.arguments, self.arguments[1:]) if option == "--restore"]
        files = [os.stat(name) for name in names if os.path.isfile(name)]
        state = tuple(part for file in files for part in (file.st_size, file.st_mtime_ns))
        return hashlib.sha256(repr((self.arguments, state)).encode(errors="surrogateescape")).hexdigest()[:16]

    def command(self):
        """Command for a shell, with its own picture and statistics."""
        return " ".join(["gicube-render", *map(quoted, self.arguments)]) + " -o picture.exr --stats run.json"


class RunFolder:
    """Folder of runs: KEY.json, which exists when the run is done, KEY.exr and KEY.log. Raises FileError."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise FileError(f"{folder}: folder: expected one that can be made, "
                            f"got {os.strerror(error.errno)}") from error

    def picture(self, run):
        return self.folder / f"{run.key()}.exr"

    def has(self, run):
        return (self.folder / f"{run.key()}.json").exists()

    def carry_out(self, run, program):
        """A killed run leaves no result for has(). Raises RunFailed with the command."""
        key = run.key()
        parts = {self.folder / f"{key}.part.{kind}": self.folder / f"{key}.{kind}" for kind in ("exr", "json")}
        picture, statistics = map(str, parts)
        try:
            run_to_end(program, [*run.arguments, "-o", picture, "--stats", statistics, "--quiet"],
                       self.folder / f"{key}.log")
        except RunFailed as failure:
            for part in parts:
                part.unlink(missing_ok=True)
            raise RunFailed(f"{run.command()}\n  {failure}") from failure
        for part, whole in parts.items():  # the statistics last: they mark the run as done
            part.replace(whole)

    def read(self, run):
        """Its statistics. Raises FileError."""
        file = self.folder / f"{run.key()}.json"
        try:
            statistics = json.loads(file.read_text())
        except (OSError, ValueError):
            statistics = None
        if not isinstance(statistics, dict):
            raise FileError(f"{file}: statistics: expected a JSON object, got something else")
        return statistics


def all_at_once(tasks, jobs):
    """Calls the functions, `jobs` in parallel (0: one per core), and yields their results in order of completion. After
    a failure or Ctrl-C, no more start; it is raised when the running ones have ended."""
    failed = threading.Event()

    def begin(task):
        if not failed.is_set():
            try:
                return task()
            except BaseException:
                failed.set()
                raise
        return None
    with concurrent.futures.ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
        try:
            for each in concurrent.futures.as_completed([pool.submit(begin, task) for task in tasks]):
                yield each.result()
        finally:
            failed.set()


def carry_out_all(folder, runs, program, jobs, meter):
    """Does the runs without a result, like all_at_once(). `meter`: see progress()."""
    left = [run for run in runs if not folder.has(run)]
    with meter(len(left)) as bar:
        for _ in all_at_once([functools.partial(folder.carry_out, run, program) for run in left], jobs):
            bar.update()


def progress(name, total, quiet=False):
    """A progress bar on standard error; call its update() after each run. Without a terminal it is drawn ten times."""
    seldom = {} if sys.stderr.isatty() else {"miniters": total / 10, "mininterval": 0}
    return tqdm(desc=name, total=total, unit=" runs", disable=quiet, dynamic_ncols=True, **seldom)


def figure_or_nan(statistics, name):
    """A number of a run's statistics: a name of their first level, or a JSON pointer ("/counters/bus.up.bytes/value").
    Not-a-number if the fidelity level does not model it."""
    value = statistics
    for part in name[1:].split("/") if name.startswith("/") else [name]:
        part = part.replace("~1", "/").replace("~0", "~") if name.startswith("/") else part
        if isinstance(value, list) and part.isdigit() and int(part) < len(value):
            value = value[int(part)]
        elif isinstance(value, dict) and part in value:
            value = value[part]
        else:
            return math.nan
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else math.nan


def figure(statistics, name):
    """The number, as above. Raises InputError if there is no such number."""
    value = figure_or_nan(statistics, name)
    if math.isnan(value):
        raise InputError(name, "a number in the run's statistics", "none of that name")
    return value
