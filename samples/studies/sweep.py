#!/usr/bin/python3
"""gicube-sweep: gicube-render over a grid of parameters, cost against error."""
import argparse
import difflib
import functools
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
from studies.runs import (  # noqa: E402
    InputError, Run, RunFailed, RunFolder, carry_out_all, figure, figure_or_nan, is_field, progress, quoted)
from studies.sensitivity import sensitivity, table  # noqa: E402
from studies.sweep_chart import draw_chart  # noqa: E402
from studies.table import FileError, cell, csv_text, on_front, write_whole  # noqa: E402

PROGRAM = "gicube-sweep"
ABOUT = """\
Run gicube-render over a grid of parameters, and chart cost against error.
Usage: gicube-sweep [OPTIONS] INPUT...

Positionals:
  INPUT TEXT ... REQUIRED     scenes or volumes for gicube-render

Options:
"""
NOTES = """
The same command continues an interrupted sweep: FOLDER/runs keeps finished runs. Every run has --threads 1, unless
--fix threads=N.
Exit codes: 0 done, 1 failed, 2 wrong usage.

  gicube-sweep builtin:buckyball --vary step=0.25,0.5,1,2 --vary jitter=off,on \\
    --reference step=0.0625 --reference jitter=off --fix fidelity=cycle -o out
"""
ITS_OWN = ("output", "stats", "quiet", "frames")  # options of gicube-render that the sweep sets
HARDLY = 0.02  # chosen: nothing that a picture of speed would show


class Parser(argparse.ArgumentParser):
    """Formats help like the SDK's other programs, for driver/cmake/program_pages.py; errors have one line."""

    def __init__(self, program, about, notes):
        super().__init__(program, add_help=False, allow_abbrev=False)
        self.about, self.notes = about, notes

    def format_help(self):
        text = self.about
        for option in self._optionals._group_actions:
            head = " ".join(filter(None, (",".join(option.option_strings), option.metavar)))
            text += f"  {head:27} {option.help}\n" if len(head) < 28 else f"  {head}\n{30 * ' '}{option.help}\n"
        return text + self.notes

    def option(self, *names, **fields):
        self.add_argument(*names, **{"action": Once} | fields)

    def common_options(self):
        self.option("-h", "--help", action=Said, nargs=0, const=Parser.format_help,
                    help="Print this help message and exit")
        self.option("--version", action=Said, nargs=0, const=lambda _: f"{self.prog} {version()}\n",
                    help="Display program version information and exit")

    def output_options(self, name, chart, shard):
        self.option("-o", "--output", metavar="FOLDER REQUIRED", dest="folder", type=pathlib.Path, required=True,
                    help="write NAME.csv, NAME.json and runs/ here")
        self.option("--name", metavar=f"TEXT={name}", default=name, help="name of the files")
        self.option("--title", metavar="TEXT", help="title of the chart")
        self.option("--jobs", metavar="INT:INT in [0 - 1024]=0", default="0", type=jobs_of,
                    help="number of parallel runs; 0 = one per core")
        self.option("--shard", metavar="I/N", type=shard_of, help=shard)
        self.option("--chart", action="store_true", help=chart)
        self.option("--quiet", action="store_true", help="print only errors")

    def error(self, message):
        words = message.removeprefix("unrecognized arguments: ").split()
        unknown = [word.split("=")[0]
                   for word in words if word.startswith("--")] if message.startswith("unrecognized") else []
        names = [name.lstrip("-") for name in self._option_string_actions]
        near = [difflib.get_close_matches(option.lstrip("-"), names, 1) for option in unknown]
        if unknown:
            message = "; ".join(f"{option}: no such option" + "".join(f", the nearest is --{name}" for name in found)
                                for option, found in zip(unknown, near))
        self.exit(2, f"{self.prog}: {message}\n")


class Said(argparse.Action):
    def __call__(self, parser, *_):
        print(self.const(parser), end="", flush=True)
        parser.exit()


class Once(argparse.Action):
    def __call__(self, parser, given, value, _=None):
        if getattr(given, self.dest) is not self.default:
            raise argparse.ArgumentError(self, "expected once, got it twice")
        setattr(given, self.dest, value)


def parser_of_options():
    parser = Parser(PROGRAM, ABOUT, NOTES)
    parser.add_argument("inputs", nargs="*")
    option = parser.option

    def repeatable(name, metavar, dest, kind, text):
        option(name, metavar=f"{metavar} ...", action="append", default=[], dest=dest, type=kind, help=text)
    parser.common_options()
    repeatable("--vary", "NAME=V,V...", "parameters", parse_parameter,
               "a parameter and its values: an option of gicube-render without dashes (flags: on, off), or a field of "
               "the board's configuration; repeatable: runs all combinations")
    repeatable("--fix", "NAME=VALUE", "fixed", parse_setting, "a parameter with the same value in every run")
    option("--reference", metavar="NAME=VALUE ... Excludes: --reference-picture", action="append", default=[],
           type=parse_setting,
           help="compare each run with the same run with this value; repeatable. Without it and --reference-picture, "
                "only costs are measured")
    option("--reference-picture", metavar="TEXT:FILE Excludes: --reference", type=file_of,
           help="compare all runs with this EXR")
    option("--cost", metavar="TEXT=frame_ms", default="frame_ms",
           help="the cost, a number of gicube-render's --stats: a name, or a JSON pointer")
    option("--error", metavar="TEXT=picture", default="picture",
           help="the error: picture (root mean square difference), or a number as for --cost (relative difference)")
    repeatable("--also", "FIGURE", "also", str, "further columns: numbers as for --cost")
    repeatable("--also-error", "FIGURE", "also_errors", str, "further columns: relative differences of numbers")
    option("--sensitivity", action="store_true",
           help="instead of --vary, change each chosen number of the board's configuration (gicube-board "
                "--explain-config) by 1% or the smallest legal step down and up, one at a time, and sort them by the "
                "change of the cost")
    parser.output_options("sweep", chart="draw NAME.svg, and cost by each parameter (needs matplotlib)",
                          shard="do only every Nth run of this sweep, from the Ith on (1/N to N/N), and write no table "
                                "and no chart; the same command without --shard writes them when all shards are in "
                                "FOLDER/runs")
    return parser


def file_of(text):
    if not os.path.exists(text) or os.path.isdir(text):
        raise argparse.ArgumentTypeError(f'expected a file, got "{text}"')
    return text


def jobs_of(text):
    if not (re.fullmatch(r"[0-9]{1,4}", text) and int(text) <= 1024):
        raise argparse.ArgumentTypeError(f'expected a number from 0 to 1024, got "{text}"')
    return int(text)


def shard_of(text):
    """I/N as (I, N)."""
    found = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    if not (found and 1 <= int(found[1]) <= int(found[2])):
        raise argparse.ArgumentTypeError(f'expected I/N with 1 <= I <= N, as 2/8, got "{text}"')
    return int(found[1]), int(found[2])


def parse_setting(text):
    """NAME=VALUE, with the value as text."""
    name, _, value = text.partition("=")
    if not name or not value or name.startswith("-"):
        raise argparse.ArgumentTypeError(f'expected NAME=VALUE, the name without dashes, got "{text}"')
    return name, value


def parse_parameter(text):
    """NAME=V,V...; semicolons separate values with commas: "eye=0,-300,0;0,-400,0"."""
    name, value = parse_setting(text)
    values = value.split(";" if ";" in value else ",")
    for i, each in enumerate(values):
        if not each:
            raise argparse.ArgumentTypeError(f'{name}: expected values between separators, got "{text}"')
        if each in values[:i]:
            raise argparse.ArgumentTypeError(f'{name}: expected each value once, got "{each}" twice')
    return name, values


def options_of(arguments):
    parser = parser_of_options()
    end = arguments.index("--") if "--" in arguments else len(arguments)  # parse_intermixed_args() passes over it
    options = parser.parse_intermixed_args(arguments[:end])
    inputs = options.inputs + arguments[end + 1:]
    if not inputs:
        parser.error("INPUT is required")
    options.parameters.insert(0, ("input", inputs))
    names = [name for name, _ in options.parameters + options.fixed]
    for name in sorted(names):
        if names.count(name) > 1:
            parser.error(f"{name}: expected once among INPUT, --vary and --fix, got it twice")
        if name in ITS_OWN:
            parser.error(f"{name}: expected another parameter, it is the sweep's own")
    if options.sensitivity:
        given = [name for name, value in (("--vary", options.parameters[1:]), ("--reference", options.reference),
                                          ("--chart", options.chart),
                                          ("--reference-picture", options.reference_picture), ("--also", options.also),
                                          ("--also-error", options.also_errors), ("--shard", options.shard)) if value]
        if given or len(inputs) > 1:
            parser.error(f"--sensitivity: expected one INPUT and none of {given[0] if given else '--vary'}")
    elif options.reference and options.reference_picture:
        parser.error("--reference: expected without --reference-picture, got both")
    options.compares = bool(options.reference or options.reference_picture)
    if not options.compares and (options.error != "picture" or options.also_errors):
        parser.error(f"{'--also-error' if options.also_errors else '--error'}: expected with --reference, got none")
    if options.reference_picture and options.error != "picture":
        parser.error(f'--error: expected picture with --reference-picture, got "{options.error}"')
    if options.reference_picture and options.also_errors:
        parser.error("--also-error: expected with --reference, got --reference-picture")
    if "threads" not in names:
        options.fixed.append(("threads", "1"))
    return options


def grid(parameters):
    """All combinations, as dictionaries; the last parameter varies fastest."""
    return [dict(zip([name for name, _ in parameters], values))
            for values in itertools.product(*(values for _, values in parameters))]


def arguments_of(point):
    """The arguments for gicube-render: the input first."""
    words = [point["input"]] if "input" in point else []
    for name, value in point.items():
        if is_field(name):
            words += ["--set", f"{name}={value}"]
        elif name != "input" and value == "on":
            words.append(f"--{name}")
        elif name != "input" and value != "off":
            words += [f"--{name}", value]
    return words


def relative(value, reference):
    return abs(value) if reference == 0 else abs(value / reference - 1)


def run_sweep(options, folder, render):
    """Does the runs that the folder does not have. A shard returns nothing. Else returns a row per point: its settings,
    cost, error (not-a-number for a reference, or without a comparison), further figures, whether it is a reference,
    whether it is on the Pareto front, its run. Raises RunFailed, FileError, InputError (a figure that a run does not
    have)."""
    one = options.reference_picture
    pairs = [(point, Run(arguments_of(point | dict(options.fixed))),
              Run(arguments_of(point | dict(options.fixed) | dict(options.reference))))
             for point in grid(options.parameters)]
    needed = [run for _, run, _ in pairs] + ([] if one else [reference for *_, reference in pairs])
    runs = list({run.key(): run for run in reversed(needed)}.values())[::-1]  # each once, at its first place
    if options.shard:  # of all runs, not only of the remaining ones, so that parallel shards have different runs
        first, step = options.shard
        runs = runs[first - 1::step]
    carry_out_all(folder, runs, render, options.jobs,
                  functools.partial(progress, PROGRAM, quiet=options.quiet or not sys.stderr.isatty()))
    if options.shard:
        return None

    exact, rows = functools.cache(read_picture), []
    for point, run, reference in pairs:
        statistics = folder.read(run)
        row = SimpleNamespace(point=point, cost=figure(statistics, options.cost), run=run,
                              fidelity=statistics.get("fidelity"),
                              invisible=statistics.get("invisible"),
                              is_reference=bool(options.reference) and run.key() == reference.key())
        row.also = [figure_or_nan(statistics, name) for name in options.also]
        compared = None if one else folder.read(reference)
        row.also += [relative(figure_or_nan(statistics, name), figure(compared, name)) for name in options.also_errors]
        if row.is_reference or not options.compares:
            row.error = math.nan
        elif options.error == "picture":
            row.error = rmse(read_picture(folder.picture(run)), exact(one or folder.picture(reference)))
        else:
            row.error = relative(figure(statistics, options.error), figure(compared, options.error))
        rows.append(row)
    mark_front(rows)
    return rows


def carry_out_sensitivity(options, folder, command):
    """Prints the table, and writes NAME.csv and NAME.json. Raises as run_sweep()."""
    meter = functools.partial(progress, PROGRAM, quiet=options.quiet or not sys.stderr.isatty())
    arguments = arguments_of({"input": options.parameters[0][1][0]} | dict(options.fixed))
    rows = sensitivity(arguments, options.fixed, options.cost, program("gicube-board"),
                       lambda runs: carry_out_all(folder, runs, program("gicube-render"), options.jobs, meter),
                       folder.read)
    lines = [["number", "value", options.cost, "% for 1%", "scatter", "step to", "change", "command"]]
    lines += [[row.name, row.value, cell(row.cost), cell(row.elasticity), int(row.is_scatter), to, cell(change),
               run.command()]
              for row in rows for to, change, run in zip(row.to, row.changes, row.runs)]
    steps = [{"number": row.name, "value": row.value, options.cost: row.cost,
              "elasticity": None if math.isnan(row.elasticity) else row.elasticity, "scatter": row.is_scatter,
              "steps": [{"to": to, "change": change, "command": run.command()} for to, change,
                        run in zip(row.to, row.changes, row.runs)]}
             for row in rows]
    base = str(options.folder / options.name)
    write_whole(f"{base}.csv", csv_text(lines))
    write_whole(f"{base}.json", json_file({"cost": options.cost, "sensitivity": steps}, command))
    if not options.quiet:
        print("\n".join(table(rows, options.cost)))


def mark_front(rows):
    """A reference has no error; without references the cheapest runs are the front."""
    for row, on in zip(rows, on_front([(row.cost, 0 if math.isnan(row.error) else row.error) for row in rows])):
        row.on_front = on


def also_names(options):
    return options.also + [f"error {name}" for name in options.also_errors]


def table_text(options, rows):
    """CSV: a line for each row, a column for each setting; the command last."""
    names = list(dict.fromkeys(name for row in rows for name in row.point))
    lines = [[options.cost, f"error {options.error}", "front", "reference", *also_names(options), *names, "command"]]
    for row in rows:
        lines.append([cell(row.cost), cell(row.error), int(row.on_front), int(row.is_reference), *map(cell, row.also),
                      *(row.point.get(name, "") for name in names), row.run.command()])
    return csv_text(lines)


def json_text(options, rows, command):
    """All points, and the front."""
    names = [options.cost, f"error {options.error}", *also_names(options)]
    points = [{"settings": row.point,
               **{name: None if math.isnan(value) else value for name,
                  value in zip(names, [row.cost, row.error, *row.also])},
               "reference": row.is_reference, "front": row.on_front, "command": row.run.command()} for row in rows]
    return json_file({"cost": options.cost, "error": options.error,
                      "front": [point for point in points if point["front"]], "points": points}, command)


def json_file(whole, command, program_name=PROGRAM):
    whole["provenance"] = {"program": program_name, "version": version(), "command": command}
    return json.dumps(whole, indent=2, ensure_ascii=False) + "\n"


def cost_change(rows, name):
    """Largest relative difference of the cost between rows that differ only in this setting."""
    ranges = {}
    for row in rows:
        others = tuple(item for item in row.point.items() if item[0] != name)
        low, high = ranges.get(others, (row.cost, row.cost))
        ranges[others] = min(low, row.cost), max(high, row.cost)
    return max((high / low - 1 for low, high in ranges.values() if low > 0), default=0)


def warn_of_constant_cost(options, rows):
    """A functional board does not count the ASIC's time: most sampling parameters hardly change its frame times."""
    if options.cost != "frame_ms" or any(row.fidelity != "functional" for row in rows):
        return
    for name, values in options.parameters:
        change = cost_change(rows, name)
        if len(values) > 1 and change < HARDLY:
            print(f"{PROGRAM}: note: {name} changes frame_ms by at most {100 * change:.2g}%: at the functional level "
                  f"the ASIC takes no time. "
                  "--fix fidelity=cycle counts it", file=sys.stderr)


def warn_of_absent_figures(options, rows):
    for column, name in enumerate(options.also):
        if all(math.isnan(row.also[column]) for row in rows):
            print(f"{PROGRAM}: warning: --also {name}: no run has a number of that name", file=sys.stderr)


def warn_of_invisible(rows):
    for text in dict.fromkeys(row.invisible for row in rows if row.invisible):
        print(f"{PROGRAM}: note: {text}: {sum(row.invisible == text for row in rows)} of {len(rows)} runs",
              file=sys.stderr)


def print_front(options, rows):
    front = sorted((row for row in rows if row.on_front), key=lambda row: row.cost)
    if options.compares:
        print(f"{options.cost:>12}  {'error':>12}  of {len(rows)} runs, no other is cheaper and better:")
    else:
        print(f"{options.cost:>12}  of {len(rows)} runs, no other is cheaper:")
    for row in front:
        error = f"  {'reference' if row.is_reference else f'{row.error:.6g}':>12}" if options.compares else ""
        print(f"{row.cost:12.6g}{error}  {row.run.command()}")


def program(name):
    """Path of a program of the SDK: beside this one, also through a link, or on the PATH."""
    place = pathlib.Path(getattr(sys.modules["__main__"], "__file__", __file__)).absolute()
    while not (place.parent / name).exists() and place.is_symlink():
        place = place.parent / place.readlink()
    return str(place.parent / name) if (place.parent / name).exists() else name


def version():
    said = subprocess.run([program("gicube-board"), "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
    return said.split()[-1]


def sweep(arguments):
    """Runs the program with these arguments. Raises RunFailed, FileError, InputError."""
    options = options_of(arguments)
    folder, command = RunFolder(options.folder / "runs"), " ".join([PROGRAM, *map(quoted, arguments)])
    if options.sensitivity:
        carry_out_sensitivity(options, folder, command)
        return
    rows = run_sweep(options, folder, program("gicube-render"))
    if rows is None:
        return
    base = str(options.folder / options.name)
    write_whole(f"{base}.csv", table_text(options, rows))
    write_whole(f"{base}.json", json_text(options, rows, command))
    if options.chart:
        draw_chart(options, rows, f"{base}.svg")
    if not options.quiet:
        warn_of_absent_figures(options, rows)
        warn_of_constant_cost(options, rows)
        warn_of_invisible(rows)
        print_front(options, rows)


def carry_out_program(name, work):
    """Calls work(arguments of the command line), and prints errors as one line. Returns the exit code."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        work(sys.argv[1:])
        sys.stdout.flush()
    except (RunFailed, FileError, InputError, MemoryError, OSError, subprocess.CalledProcessError) as error:
        text = f"standard output: {os.strerror(error.errno)}" if isinstance(error,
            OSError) and not error.filename else error
        print(f"{name}: {text}", file=sys.stderr)
        sys.stdout = None  # its buffer cannot be written
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(carry_out_program(PROGRAM, sweep))
