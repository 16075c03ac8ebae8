"""gicube-sweep --sensitivity: changes of a run's cost with each chosen number of the board's configuration."""
import math
import re
import subprocess
from types import SimpleNamespace

from studies.runs import InputError, Run, figure, is_field

MEMORIES = ("rdram", "ddr")  # only the used one is read
SMALL = 100  # a step is this part of the number, or 1: rounding would hide single clocks of a fast clock


def stepped(value, legal):
    """Nearest values above and below within a schema's range; none for a switch."""
    numbers = [int(number) for number in re.findall(r"\d+", legal)]
    if ".." in legal:
        low, high = numbers[0], numbers[1] if re.search(r"\.\.\d", legal) else math.inf
        step = max(1, value // SMALL)
        return [] if (low, high) == (0, 1) else [to for to in (value + step, value - step) if low <= to <= high]
    return sorted(number for number in numbers if number > value)[:1] + sorted(number
        for number in numbers if number < value)[-1:]


def chosen_numbers(explained, with_energy=False):
    """Name, value and range of each number that gicube-board --explain-config marks as `chosen` and that the level
    models. `with_energy`: also all prices of energy, because none of them is certain; else none of them."""
    rows = [re.split(r"\s{2,}", line.strip()) for line in explained.splitlines()]
    memory = next((row[1] for row in rows if row[0] == "memory"), "")
    found = []
    for row in rows:
        part = row[0].split(".")[0]
        if len(row) < 4 or not row[1].isdigit() or row[3].startswith("not modelled"):
            continue
        if not with_energy if part == "energy" else not re.search("(^|: )chosen:", row[3]):
            continue
        if part not in MEMORIES or part == memory:
            found.append((row[0], int(row[1]), row[2]))
    return found


def board_arguments(settings):
    """The options for gicube-board in the settings of a run."""
    words = []
    for name, value in settings:
        if name == "board":
            raise InputError("board", "none with --sensitivity, whose boards are private", f'"{value}"')
        if name == "config":
            words += ["--config", value]
        elif name == "fidelity" or is_field(name):
            words += ["--set", f"{name}={value}"]
    return words


def explain(board, words):
    """None if the board refuses the configuration."""
    done = subprocess.run([board, *words, "--explain-config"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)
    return done.stdout if done.returncode == 0 else None


def steps_of(board, settings, with_energy=False):
    """A row for each number: its name, its value, and the values below and above it that the board accepts."""
    words = board_arguments(settings)
    rows = []
    for name, value, legal in chosen_numbers(explain(board, words) or "", with_energy):
        to = [each for each in sorted(stepped(value, legal)) if explain(board, [*words, "--set", f"{name}={each}"]) is
              not None]
        if to:
            rows.append(SimpleNamespace(name=name, value=value, to=to))
    return rows


def finish(row, cost, costs):
    """The row with the changes of the cost at its steps, their slope in per cent of cost per cent of the number
    (not-a-number if one of them is 0), and whether both steps change it in the same direction, which is scatter and not
    a slope."""
    row.cost, row.changes = cost, [each - cost for each in costs]
    points = sorted([(row.value, 0.0), *zip(row.to, row.changes)])
    (low, first), (high, last) = points[0], points[-1]
    row.elasticity = (last - first) / cost / ((high - low) / row.value) if row.value and cost else math.nan
    row.is_scatter = len(row.changes) == 2 and row.changes[0] * row.changes[1] > 0
    return row


def sensitivity(arguments, settings, cost, board, carry_out, read):
    """Rows of finish(), sorted by the largest change, then by the slope. `carry_out` does runs, `read` returns a run's
    statistics. Raises what they raise, and InputError."""
    board_arguments(settings)
    base = Run(arguments)
    carry_out([base])
    statistics = read(base)
    rows = steps_of(board, settings, "energy" in cost or "power" in cost)
    for row in rows:
        row.runs = [Run([*arguments, "--set", f"{row.name}={to}"]) for to in row.to]
    carry_out([run for row in rows for run in row.runs])
    for row in rows:
        finish(row, figure(statistics, cost), [figure(read(run), cost) for run in row.runs])
    return sorted(rows, key=lambda row: (row.is_scatter,
                                         -abs(row.elasticity) if row.elasticity == row.elasticity else 1,
                                         -max(map(abs, row.changes))))


def table(rows, cost):
    """Lines for the user."""
    lines = [f"{cost} {rows[0].cost:.6g}" if rows else f"{cost}: no chosen number is read",
             f"{'chosen number':28} {'value':>8} {'steps to':>15} {'change':>23} {'% for 1%':>9}"]
    for row in rows:
        share = "scatter" if row.is_scatter else "" if math.isnan(row.elasticity) else f"{row.elasticity:.4f}"
        steps, changes = ", ".join(map(str, row.to)), ", ".join(f"{change:+.6g}" for change in row.changes)
        lines.append(f"{row.name:28} {row.value:8} {steps:>15} {changes:>23} {share:>9}")
    return lines
