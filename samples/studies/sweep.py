#!/usr/bin/python3
"""gicube-sweep: gicube-render over a grid of parameters, cost against error."""
import itertools
import json
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
from types import SimpleNamespace

sys.dont_write_bytecode = True
sys.path.insert(1, str(pathlib.Path(__file__).resolve().parents[1]))  # the package studies

from studies.pictures import read_picture, rmse  # noqa: E402
from studies.runs import (InputError, ProgressLine, Run, RunFailed, RunFolder, carry_out_all, figure, figure_or_nan,  # noqa: E402
                          quoted)
from studies.table import FileError, cell, csv_text, on_front, write_whole  # noqa: E402

PROGRAM = "gicube-sweep"
# Options are read from their lines here: NAME, a value's name and default, ... for those that may be given again.
HELP = """\
Runs gicube-render over a grid of parameters, and charts cost against error.
Usage: gicube-sweep [OPTIONS] INPUT...

Positionals:
  INPUT TEXT ... REQUIRED     scenes or volumes, as gicube-render takes them

Options:
  -h,--help                   Print this help message and exit
  --version                   Display program version information and exit
  --vary NAME=V,V... ...      a parameter and its values, NAME=V,V...: an option of gicube-render without dashes (flags: on, off) or \
a field of the board's configuration; repeatable: all combinations are run
  --fix NAME=VALUE ...        the same for every run
  --reference NAME=VALUE ... Excludes: --reference-picture
                              a run's reference is the same run with this in place; repeatable
  --reference-picture TEXT:FILE Excludes: --reference
                              an EXR that all runs are compared with
  --cost TEXT=frame_ms        a number of gicube-render's --stats: a name, or a JSON pointer
  --error TEXT=picture        picture: root mean square difference; or a number as for --cost: relative difference
  --also FIGURE ...           further numbers as for --cost, as columns
  --also-error FIGURE ...     the same of further numbers' relative differences
  -o,--output FOLDER REQUIRED NAME.csv, NAME.json and runs/ go there
  --name TEXT=sweep           of the files
  --title TEXT                of the chart
  --jobs INT:INT in [0 - 1024]=0
                              runs at once; 0 = one per core
  --chart                     draw NAME.svg (needs matplotlib)
  --quiet                     only errors

A sweep that was killed goes on where it was when the same command is given again: runs that are done are kept in
FOLDER/runs and not done again. Every run has --threads 1, unless --fix threads=N.
Exit codes: 0 done, 1 failed, 2 wrong usage.

  gicube-sweep builtin:buckyball --vary step=0.25,0.5,1,2 --vary jitter=off,on \\
    --reference step=0.0625 --reference jitter=off --fix fidelity=approximate -o out
"""
OPTION = re.compile(r"^  (?:(-\w),)?--([a-z-]+)(?: (NAME=[^ ]+|[A-Z]+)(?::[A-Z]+(?: in \[.*\])?)?(?:=(\w+))?( \.\.\.)?)?(?= |$)", re.MULTILINE)
KINDS = {name: (value, default, bool(many)) for _, name, value, default, many in OPTION.findall(HELP)}
SHORT = {letter: name for letter, name, *_ in OPTION.findall(HELP) if letter}
ITS_OWN = ("output", "stats", "quiet", "frames")  # options of gicube-render that the sweep sets
HARDLY = 0.02  # chosen: less than frame times of the approximate level are off by


class UsageError(Exception):
    """The command line is wrong: exit code 2."""


def words_of(arguments):
    """Options by their names, as lists of what was given; the inputs; what is no option. Raises UsageError."""
    given, inputs, unknown, left = {}, [], [], list(arguments)
    while left:
        word = left.pop(0)
        if word == "--":
            inputs += left
            break
        if not word.startswith("-") or word == "-":
            inputs.append(word)
            continue
        name, equals, value = word.removeprefix("--").partition("=")
        if not word.startswith("--"):
            name, equals, value = SHORT.get(word[:2]), word[2:], word[2:]
        if name not in KINDS or (equals and not KINDS[name][0]):
            unknown.append(word)
        elif KINDS[name][0] and not equals and not left:
            raise UsageError(f"--{name}: 1 required {KINDS[name][0]} missing")
        else:
            given.setdefault(name, []).append(value if equals else left.pop(0) if KINDS[name][0] else "")
    for name, values in given.items():
        if KINDS[name][0] and not KINDS[name][2] and len(values) > 1:
            raise UsageError(f"--{name}: At Most 1 required but received {len(values)}")
    return given, inputs, unknown


def check_words(given, inputs, unknown):
    if "jobs" in given and not (re.fullmatch(r"\d{1,9}", given["jobs"][0]) and int(given["jobs"][0]) <= 1024):
        raise UsageError(f"--jobs: Value {given['jobs'][0]} not in range 0 to 1024")
    for file in given.get("reference-picture", []):
        if not os.path.exists(file):
            raise UsageError(f"--reference-picture: File does not exist: {file}")
        if os.path.isdir(file):
            raise UsageError(f"--reference-picture: File is actually a directory: {file}")
    for name, there in (("INPUT", inputs), ("--output", "output" in given)):
        if not there:
            raise UsageError(f"{name} is required")
    if "reference" in given and "reference-picture" in given:
        raise UsageError("--reference excludes --reference-picture")
    if unknown:
        several = len(unknown) > 1
        raise UsageError(f"The following argument{'s were' if several else ' was'} not expected: {' '.join(reversed(unknown))}")


def options_of(arguments):
    """None if help or the version was asked for, and printed. Raises UsageError."""
    given, inputs, unknown = words_of(arguments)
    if "help" in given:
        print(HELP, end="")
        return None
    if "version" in given:
        print(PROGRAM, version())
        return None
    check_words(given, inputs, unknown)

    def one(name):
        return given.get(name, [KINDS[name][1]])[-1]
    try:
        parameters = [("input", inputs), *map(parse_parameter, given.get("vary", []))]
        fixed, reference = ([parse_setting(text) for text in given.get(name, [])] for name in ("fix", "reference"))
    except InputError as error:
        raise UsageError(str(error)) from error
    if "threads" not in dict(fixed) and "threads" not in dict(parameters):
        fixed.append(("threads", "1"))
    options = SimpleNamespace(
        parameters=parameters, fixed=fixed, reference=reference, reference_picture=one("reference-picture"),
        cost=one("cost"), error=one("error"), also=given.get("also", []), also_errors=given.get("also-error", []),
        folder=pathlib.Path(one("output")), name=one("name"), title=one("title"), jobs=int(one("jobs")),
        chart="chart" in given, quiet="quiet" in given)
    check(options)
    return options


def check(options):
    names = sorted(name for name, _ in options.parameters + options.fixed)
    for name, following in zip(names, names[1:]):
        if name == following:
            raise UsageError(f"{name}: expected once among INPUT, --vary and --fix, got it twice")
    for own in ITS_OWN:
        if own in names:
            raise UsageError(f"{own}: expected another parameter, it is the sweep's own")
    if not options.reference and not options.reference_picture:
        raise UsageError("--reference or --reference-picture: expected one of them, got none")
    if options.reference_picture and options.error != "picture":
        raise UsageError(f'--error: expected picture with --reference-picture, got "{options.error}"')
    if options.reference_picture and options.also_errors:
        raise UsageError("--also-error: expected with --reference, got --reference-picture")


def parse_setting(text):
    """NAME=VALUE, the value as it stands. Raises InputError."""
    name, _, value = text.partition("=")
    if not name or not value or name.startswith("-"):
        raise InputError("parameter", "NAME=VALUE, the name without dashes", f'"{text}"')
    return name, value


def parse_parameter(text):
    """NAME=V,V...; values that have commas of their own stand between semicolons: "eye=0,-300,0;0,-400,0". Raises InputError."""
    name, value = parse_setting(text)
    values = value.split(";" if ";" in value else ",")
    for i, each in enumerate(values):
        if not each:
            raise InputError(name, "values between separators", f'"{text}"')
        if each in values[:i]:
            raise InputError(name, "each value once", f'"{each}" twice')
    return name, values


def grid(parameters):
    """All combinations, as dictionaries; the last parameter varies fastest."""
    return [dict(zip([name for name, _ in parameters], values)) for values in itertools.product(*(values for _, values in parameters))]


def arguments_of(point):
    """As gicube-render takes them: the input first."""
    words = [point["input"]] if "input" in point else []
    for name, value in point.items():
        if "." in name:
            words += ["--set", f"{name}={value}"]
        elif name != "input" and value == "on":
            words.append(f"--{name}")
        elif name != "input" and value != "off":
            words += [f"--{name}", value]
    return words


def relative(value, reference):
    return abs(value) if reference == 0 else abs(value / reference - 1)


def run_sweep(options, folder, render, progress):
    """Runs what the folder does not have yet. Returns a row a point: its settings, cost, error, further figures, whether it is a reference,
    whether it is on the Pareto front, its run. Raises RunFailed, FileError, InputError (a figure that a run does not have)."""
    one = options.reference_picture
    pairs = [(point, Run(arguments_of(point | dict(options.fixed))),
              Run(arguments_of(point | dict(options.fixed) | dict(options.reference)))) for point in grid(options.parameters)]
    needed = [run for _, run, _ in pairs] + ([] if one else [reference for *_, reference in pairs])
    runs = list({run.key(): run for run in reversed(needed)}.values())[::-1]  # each once, where it first comes
    carry_out_all(folder, runs, render, options.jobs, lambda done: progress.show(f"{done} of {len(runs)} runs"))

    pictures, rows = {}, []

    def exact(file):
        if file not in pictures:
            pictures[file] = read_picture(file)
        return pictures[file]
    for point, run, reference in pairs:
        statistics = folder.read(run)
        row = SimpleNamespace(point=point, cost=figure(statistics, options.cost), run=run, also=[], fidelity=statistics.get("fidelity"),
                              is_reference=not one and run.key() == reference.key(), on_front=False)
        row.also = [figure_or_nan(statistics, name) for name in options.also]
        compared = None if one else folder.read(reference)
        row.also += [relative(figure_or_nan(statistics, name), figure(compared, name)) for name in options.also_errors]
        if options.error == "picture":
            row.error = rmse(read_picture(folder.picture(run)), exact(one or folder.picture(reference)))
        else:
            row.error = relative(figure(statistics, options.error), figure(compared, options.error))
        rows.append(row)
    mark_front(rows)
    return rows


def mark_front(rows):
    """References have no error, and stay out."""
    measured = [row for row in rows if not row.is_reference]
    for row, on in zip(measured, on_front([(row.cost, row.error) for row in measured])):
        row.on_front = on


def also_names(options):
    return options.also + [f"error {name}" for name in options.also_errors]


def table_text(options, rows):
    """CSV: a line for each row, a column for each setting; the command last."""
    names = list(dict.fromkeys(name for row in rows for name in row.point))
    lines = [[options.cost, f"error {options.error}", "front", "reference", *also_names(options), *names, "command"]]
    for row in rows:
        lines.append([cell(row.cost), "" if row.is_reference else cell(row.error), int(row.on_front), int(row.is_reference),
                      *map(cell, row.also), *(row.point.get(name, "") for name in names), row.run.command()])
    return csv_text(lines)


def json_text(options, rows, command):
    """The same, and the front by itself."""
    points = [{"settings": row.point, options.cost: row.cost, f"error {options.error}": None if row.is_reference else row.error,
               **{name: None if math.isnan(value) else value for name, value in zip(also_names(options), row.also)},
               "reference": row.is_reference, "front": row.on_front, "command": row.run.command()} for row in rows]
    whole = {"cost": options.cost, "error": options.error, "front": [point for point in points if point["front"]], "points": points,
             "provenance": {"program": PROGRAM, "version": version(), "command": command}}
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def draw_chart(options, rows, path):
    """All points, and the Pareto front as a line. Raises FileError."""
    try:
        from studies import draw
    except ImportError as error:
        raise RunFailed(f"--chart: expected matplotlib (Debian package python3-matplotlib), got {error}") from error
    drawn = sorted((row for row in rows if not row.is_reference and row.cost > 0 and row.error > 0), key=lambda row: row.cost)
    front = [row for row in drawn if row.on_front]
    draw.chart(path, options.title or options.name, options.cost, f"error: {options.error}",
               [draw.Series("runs", [row.cost for row in drawn], [row.error for row in drawn], look="points", colour=-1, mark=0),
                draw.Series("Pareto front", [row.cost for row in front], [row.error for row in front], boxed=True)], log_x=True, log_y=True,
               box_outside=True)


def cost_change(rows, name):
    """The largest relative difference of the cost between rows that have all settings but this in common."""
    ranges = {}
    for row in rows:
        others = tuple(item for item in row.point.items() if item[0] != name)
        low, high = ranges.get(others, (row.cost, row.cost))
        ranges[others] = min(low, row.cost), max(high, row.cost)
    return max((high / low - 1 for low, high in ranges.values() if low > 0), default=0)


def warn_of_constant_cost(options, rows):
    """A functional board counts no time of the ASIC: most parameters of the sampling hardly change its frame times."""
    if options.cost != "frame_ms" or any(row.fidelity != "functional" for row in rows):
        return
    for name, values in options.parameters:
        change = cost_change(rows, name)
        if len(values) > 1 and change < HARDLY:
            print(f"{PROGRAM}: note: {name} changes frame_ms by at most {100 * change:.2g}%: at the functional level the ASIC takes no time. "
                  "--fix fidelity=approximate counts it", file=sys.stderr)


def print_front(options, rows):
    print(f"{options.cost:>12}  {'error':>12}  of {len(rows)} runs, no other is cheaper and better:")
    for row in sorted((row for row in rows if row.on_front), key=lambda row: row.cost):
        print(f"{row.cost:12.6g}  {row.error:12.6g}  {row.run.command()}")


def program(name):
    """A program of the SDK: beside this one, also where a link leads to it; or on the PATH."""
    place = pathlib.Path(__file__).absolute()
    while not (place.parent / name).exists() and place.is_symlink():
        place = place.parent / place.readlink()
    return str(place.parent / name) if (place.parent / name).exists() else name


def version():
    said = subprocess.run([program("gicube-board"), "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
    return said.split()[-1]


def sweep(arguments):
    """What the program does with these arguments. Raises UsageError, RunFailed, FileError, InputError."""
    options = options_of(arguments)
    if options is None:
        return
    folder = RunFolder(options.folder / "runs")
    progress = ProgressLine(not options.quiet)
    try:
        rows = run_sweep(options, folder, program("gicube-render"), progress)
    finally:
        progress.clear()
    base = str(options.folder / options.name)
    write_whole(f"{base}.csv", table_text(options, rows))
    write_whole(f"{base}.json", json_text(options, rows, " ".join([PROGRAM, *map(quoted, arguments)])))
    if options.chart:
        draw_chart(options, rows, f"{base}.svg")
    if not options.quiet:
        warn_of_constant_cost(options, rows)
        print_front(options, rows)


def main():
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        sweep(sys.argv[1:])
        sys.stdout.flush()
    except UsageError as error:
        print(f"{PROGRAM}: {error}", file=sys.stderr)
        return 2
    except (RunFailed, FileError, InputError, MemoryError, OSError, subprocess.CalledProcessError) as error:
        text = f"standard output: {os.strerror(error.errno)}" if isinstance(error, OSError) and not error.filename else error
        print(f"{PROGRAM}: {text}", file=sys.stderr)
        sys.stdout = None  # what is left in its buffer has no place
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
