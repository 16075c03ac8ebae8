#!/usr/bin/python3
"""gicube-explore: searches the board's configurations for the Pareto front of time, energy, transistors and memory."""
import argparse
import functools
import math
import pathlib
import re
import sys
from types import SimpleNamespace

sys.dont_write_bytecode = True
sys.path.insert(1, str(pathlib.Path(__file__).resolve().parents[1]))  # the package studies

from studies.hardware_cost import Refused, hardware_cost  # noqa: E402
from studies.runs import (  # noqa: E402
    InputError, Run, RunFailed, RunFolder, carry_out_all, figure_or_nan, progress, quoted)
from studies.search import check_count, search, size_of  # noqa: E402
from studies.sensitivity import board_arguments  # noqa: E402
from studies.space import KNOWN, mean, read_space  # noqa: E402
from studies.sweep import Parser, arguments_of, carry_out_program, json_file, program  # noqa: E402
from studies.table import cell, csv_text, on_front, write_whole  # noqa: E402

PROGRAM = "gicube-explore"
ABOUT = """\
Search configurations of the board for the Pareto front of frame time, energy, transistors and memory bits.
Usage: gicube-explore [OPTIONS] SPACE

Positionals:
  SPACE TEXT REQUIRED         a TOML file: scenes, fields with their values, objectives, constraints

Options:
"""
NOTES = """
The same command continues an interrupted search: FOLDER/runs keeps finished runs, like gicube-sweep's. Every run has
--threads 1, unless SPACE fixes threads.
Exit codes: 0 done, 1 failed, 2 wrong usage.

  gicube-explore space.toml --points 60 --chart -o out
"""


def options_of(arguments):
    parser = Parser(PROGRAM, ABOUT, NOTES)
    parser.add_argument("space")
    parser.common_options()
    parser.option("--points", metavar="INT=60", type=whole_number,
                  help="number of configurations to measure, at most those of the space")
    parser.option("--seed", metavar="UINT=1", default="1", type=whole_number,
                  help="seed of the search's random choices")
    parser.output_options("explore", chart="draw NAME.svg (needs matplotlib)",
                          shard="do only every Nth of the next runs of the search, from the Ith on, and write no table "
                                "and no chart; start the shards again until the search ends, then run the same command "
                                "without --shard")
    return parser.parse_args(arguments)


def whole_number(text):
    if not re.fullmatch(r"[0-9]{1,9}", text):
        raise argparse.ArgumentTypeError(f'expected a number from 0 to 999999999, got "{text}"')
    return int(text)


def figure_of(name, statistics, known):
    """Energy of the picture, and its mean power over the picture's simulated time; not-a-number without energy."""
    if name in KNOWN:
        return known[name]
    if name in ("energy", "power"):
        joules = 1e-12 * figure_or_nan(statistics, "/counters/energy.total/value")
        return joules if name == "energy" else joules / (1e-3 * figure_or_nan(statistics, "frame_ms"))
    return figure_or_nan(statistics, name)


class Explorer:
    """Measures points of a space: their settings, runs, figures, and violated constraints."""

    def __init__(self, space, options, folder):
        self.space, self.options, self.folder = space, options, folder
        self.points, self.refused, self.rounds = [], [], 0
        self.objectives = space.objectives

    def describe(self, settings):
        """A point before its runs. If the board refuses it, it has a reason instead of costs."""
        runs = [Run(arguments_of({"input": scene} | settings | dict(self.space.fixed))) for scene in self.space.scenes]
        point = SimpleNamespace(settings=settings, runs=runs, known=None, reason="", broken=[])
        try:
            cost = hardware_cost(program("gicube-board"), board_arguments([*settings.items(), *self.space.fixed]))
            point.known = {name: getattr(cost, name) for name in KNOWN}
        except Refused as refused:
            point.reason = str(refused)
            return point
        broken = [each for each in self.space.constraints if each.name in KNOWN
                  and not each.holds(point.known[each.name])]
        point.reason = broken[0].text if broken else ""
        return point

    def carry_out(self, points):
        """Does the remaining runs, or this shard's part. Returns whether all of them are done."""
        runs = list({run.key(): run for point in points for run in point.runs}.values())
        own = runs[self.options.shard[0] - 1::self.options.shard[1]] if self.options.shard else runs
        carry_out_all(self.folder, own, program("gicube-render"), self.options.jobs,
                      functools.partial(progress, PROGRAM, quiet=self.options.quiet or not sys.stderr.isatty()))
        return all(map(self.folder.has, runs))

    def finish(self, point):
        """Figures of a point after its runs: objectives as means over the scenes, constraints in the worst scene."""
        read = [self.folder.read(run) for run in point.runs]
        point.figures = {name: mean([figure_of(name, each, point.known) for each in read]) for name in self.objectives}
        point.violations = []
        for each in self.space.constraints:
            value = each.worst([figure_of(each.name, one, point.known) for one in read])
            if math.isnan(value):
                raise absent(each.name, f"constraint {each.text}")
            point.violations.append(each.violation(value))
            point.broken += [each.text] * (not each.holds(value))
        missing = [name for name, value in point.figures.items() if math.isnan(value)]
        if missing:
            raise absent(missing[0], missing[0])

    def measure_paper(self):
        """The paper's card, without changed fields. Returns False like carry_out()."""
        self.paper = self.describe({})
        if self.paper.known is None:
            raise RunFailed(self.paper.reason)
        if not self.carry_out([self.paper]):
            return False
        self.finish(self.paper)
        return True

    def measure(self, proposed):
        """Measures a round; search() calls it. Returns None if other shards still have runs of it."""
        points = [self.describe(settings) for settings in proposed]
        accepted = [point for point in points if not point.reason]
        self.rounds += 1
        if not self.carry_out(accepted):
            return None
        for point in accepted:
            self.finish(point)
        self.points += accepted
        self.refused += [point for point in points if point.reason]
        return [None if point.reason else (list(point.figures.values()), point.violations) for point in points]


def absent(name, what):
    if name in ("energy", "power"):
        return InputError(what, "counter energy.total in the run's statistics", "none of that name")
    return InputError(what, "a number in the run's statistics, or one of transistors, memory_bits, pins, energy, power",
                      "none of that name")


def command_of(point, space, folder):
    """The run for one scene; for several, a sweep over the scenes, which reuses the runs in the same folder."""
    if len(point.runs) == 1:
        return point.runs[0].command()
    settings = [word for name, value in (point.settings | dict(space.fixed)).items()
                for word in ("--fix", f"{name}={value}")]
    return " ".join(["gicube-sweep", *map(quoted, [*space.scenes, *settings]), "-o", quoted(str(folder))])


def rows_of(explorer):
    """The paper's card first, then the points by their first figure. Points that violate a constraint are not on the
    front."""
    rows = [explorer.paper, *sorted(explorer.points, key=lambda point: list(point.figures.values()))]
    for row, on in zip(rows, on_front([tuple([math.nan] if row.broken else row.figures.values()) for row in rows])):
        row.on_front = on
    return rows


def write_tables(explorer, rows, command):
    options, space = explorer.options, explorer.space
    names = [name for name, _ in space.parameters]
    lines = [[*explorer.objectives, "front", "paper", "breaks", *names, "command"]]
    lines += [[*map(cell, row.figures.values()), int(row.on_front), int(row is explorer.paper), "; ".join(row.broken),
               *(row.settings.get(name, "") for name in names), command_of(row, space, options.folder)] for row in rows]
    write_whole(options.folder / f"{options.name}.csv", csv_text(lines))
    points = [{"settings": row.settings, **row.figures, "front": row.on_front, "paper": row is explorer.paper,
               "breaks": row.broken,
               "command": command_of(row, space, options.folder)} for row in rows]
    whole = {"objectives": explorer.objectives, "scenes": space.scenes,
             "constraints": [each.text for each in space.constraints],
             "points": points, "refused": [{"settings": point.settings, "why": point.reason}
                                           for point in explorer.refused]}
    write_whole(options.folder / f"{options.name}.json", json_file(whole, command, PROGRAM))


def draw_chart(explorer, rows):
    """The first objective against each of the others."""
    try:
        from studies import draw
    except ImportError as error:
        raise RunFailed(f"--chart: expected matplotlib (Debian package python3-matplotlib), got {error}") from error
    first, *others = explorer.objectives
    kinds = [("other runs", [row for row in rows if not row.on_front and row is not explorer.paper],
              {"colour": -1, "mark": 0}),
             ("Pareto front", [row for row in rows if row.on_front], {"colour": 0, "mark": 0}),
             ("the paper's card", [explorer.paper], {"colour": 1, "mark": 3, "hollow": True})]

    def panel(name):
        series = [draw.Series(label, [row.figures[name] / unit_of(name) for row in drawn],
                              [row.figures[first] / unit_of(first) for row in drawn],
                              look="points", **look)
                  for label, drawn, look in kinds if drawn]
        positive = {of: all(row.figures[of] > 0 for row in rows) for of in (first, name)}
        return draw.Panel(label_of(name), label_of(first), series, log_x=positive[name], log_y=positive[first])
    title = explorer.options.title or f"{len(rows)} configurations of the board, the paper's card among them"
    draw.panels(explorer.options.folder / f"{explorer.options.name}.svg", title, list(map(panel, others)))


def unit_of(name):
    """Units in the chart; Mb are 2^20 bits, as in the paper."""
    return {"transistors": 1e6, "memory_bits": 2 ** 20}.get(name, 1)


def label_of(name):
    return {"frame_ms": "simulated ms of a picture", "energy": "energy of a picture, J", "power": "mean power, W",
            "transistors": "transistors of the logic, millions", "memory_bits": "on-chip memory, Mb"}.get(name, name)


def print_front(explorer, rows):
    print("  ".join(f"{name:>12}" for name in explorer.objectives) +
          f"  of {len(rows)} configurations, none is better in all:")
    for row in rows:
        if row.on_front or row is explorer.paper:
            text = " ".join(f"{name}={value}" for name,
                            value in row.settings.items()) if row is not explorer.paper else "the paper's card" + (
                "" if row.on_front else ", not on the front") + "".join(f", breaks {each}" for each in row.broken)
            print("  ".join(f"{value:12.6g}" for value in row.figures.values()) + f"  {text}")
    if explorer.refused:
        print(f"{len(explorer.refused)} more without a run ({explorer.options.name}.json lists them); the first: "
              f"{explorer.refused[0].reason}")


def warn_of_free_fields(explorer):
    """A field without a cost would reach its fastest value, which says nothing about a good card."""
    if "energy" in explorer.objectives or not set(explorer.objectives) & set(KNOWN):
        return
    for name, values in explorer.space.parameters:
        costs = [explorer.describe({name: value}).known for value in values]
        if len(values) > 1 and all(cost == costs[0] for cost in costs):
            print(f"{PROGRAM}: note: {name} costs nothing that is counted here: {', '.join(KNOWN)} are the same for "
                  f"all its values", file=sys.stderr)


def explore(arguments):
    """Runs the program with these arguments. Raises RunFailed, FileError, InputError."""
    options = options_of(arguments)
    space = read_space(options.space)
    options.points = min(60, size_of(space.parameters)) if options.points is None else options.points
    check_count(options.points, space.parameters)
    explorer = Explorer(space, options, RunFolder(options.folder / "runs"))
    done = explorer.measure_paper() and search(space.parameters, options.points, options.seed, explorer.measure)
    if options.shard:
        if not options.quiet:
            print(f"{PROGRAM}: the search is at its end" if done
                  else f"{PROGRAM}: round {explorer.rounds} waits for other shards: start them again")
        return
    rows = rows_of(explorer)
    write_tables(explorer, rows, " ".join([PROGRAM, *map(quoted, arguments)]))
    if options.chart:
        draw_chart(explorer, rows)
    if not options.quiet:
        warn_of_free_fields(explorer)
        print_front(explorer, rows)


if __name__ == "__main__":
    sys.exit(carry_out_program(PROGRAM, explore))
