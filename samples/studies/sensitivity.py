"""gicube-sweep --sensitivity: how a run's cost changes with each number of the board's configuration that was chosen."""
import math
import re
import subprocess
from types import SimpleNamespace

from studies.runs import InputError, Run, figure

READ = {"functional": ("asic", "dsp", "bus")}  # messages of the configuration that a level reads, if not all
MEMORIES = ("rdram", "ddr")  # only the one in use is read
SMALL = 100  # a step is this part of the number, or 1: single clocks of a fast clock would drown in roundings


def stepped(value, legal):
    """The nearest values above and below that a schema's range allows, in the order in which they are to be tried; none of a switch."""
    numbers = [int(number) for number in re.findall(r"\d+", legal)]
    if ".." in legal:
        low, high = numbers[0], numbers[1] if re.search(r"\.\.\d", legal) else math.inf
        step = max(1, value // SMALL)
        return [] if (low, high) == (0, 1) else [to for to in (value + step, value - step) if low <= to <= high]
    return sorted(number for number in numbers if number > value)[:1] + sorted(number for number in numbers if number < value)[-1:]


def chosen_numbers(explained, fidelity):
    """Name, value and range of each number that is marked `chosen` in what gicube-board --explain-config says, and that the level reads."""
    rows = [re.split(r"\s{2,}", line.strip()) for line in explained.splitlines()]
    memory = next((row[1] for row in rows if row[0] == "memory"), "")
    found = []
    for row in rows:
        part = row[0].split(".")[0]
        if len(row) < 4 or not row[1].isdigit() or not re.search(r"(^|: )chosen:", row[3]):
            continue
        if part in READ.get(fidelity, (part,)) and (part not in MEMORIES or part == memory):
            found.append((row[0], int(row[1]), row[2]))
    return found


def board_arguments(settings):
    """What gicube-board needs of the settings of a run."""
    words = []
    for name, value in settings:
        if name == "board":
            raise InputError("board", "none with --sensitivity, whose boards are private", f'"{value}"')
        if name == "config":
            words += ["--config", value]
        elif name == "fidelity" or "." in name:
            words += ["--set", f"{name}={value}"]
    return words


def explain(board, words):
    """None if the board refuses the configuration."""
    done = subprocess.run([board, *words, "--explain-config"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return done.stdout if done.returncode == 0 else None


def steps_of(board, settings, fidelity):
    """A row for each number: its name, value, and what it is set to; None where the board takes neither step."""
    words = board_arguments(settings)
    rows = []
    for name, value, legal in chosen_numbers(explain(board, words) or "", fidelity):
        to = stepped(value, legal)
        if to:
            taken = next((each for each in to if explain(board, [*words, "--set", f"{name}={each}"]) is not None), None)
            rows.append(SimpleNamespace(name=name, value=value, to=taken))
    return rows


def elasticity(row):
    """Per cent of cost for a per cent of the number; not-a-number if one of them is 0."""
    return row.change / row.cost / ((row.to - row.value) / row.value) if row.value and row.cost else math.nan


def sensitivity(arguments, settings, cost, board, carry_out, read):
    """Rows as of steps_of() with cost (before the step), change (of it) and elasticity, the largest first. `carry_out` has runs carried out,
    `read` gives a run's statistics. Raises what they raise, and InputError."""
    board_arguments(settings)
    base = Run(arguments)
    carry_out([base])
    statistics = read(base)
    rows = [row for row in steps_of(board, settings, statistics["fidelity"]) if row.to is not None]
    for row in rows:
        row.run = Run([*arguments, "--set", f"{row.name}={row.to}"])
    carry_out([row.run for row in rows])
    for row in rows:
        row.cost = figure(statistics, cost)
        row.change = figure(read(row.run), cost) - row.cost
        row.elasticity = elasticity(row)
    return sorted(rows, key=lambda row: (-abs(row.elasticity) if row.elasticity == row.elasticity else 1, -abs(row.change)))


def table(rows, cost):
    """Lines for people."""
    lines = [f"{'chosen number':28} {'value':>8} {'step to':>8} {cost:>12} {'change':>12} {'% for 1%':>9}"]
    for row in rows:
        share = "" if math.isnan(row.elasticity) else f"{row.elasticity:9.4f}"
        lines.append(f"{row.name:28} {row.value:8} {row.to:8} {row.cost:12.6g} {row.change:+12.6g} {share:>9}")
    return lines
