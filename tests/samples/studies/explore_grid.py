"""How much of an exhaustive grid's hypervolume the search of gicube-explore finds with a fifth of its runs.

    gicube-explore tests/samples/studies/explore_space.toml --points 300 -o out
    PYTHONPATH=samples python3 tests/samples/studies/explore_grid.py out/explore.csv 20

The hypervolume is that of the figures' logarithms, below the worst of each in the grid; and of the figures themselves,
which is easier."""
import math
import pathlib
import random
import statistics
import sys

from studies.search import hypervolume, search
from studies.table import on_front, rows_of

FIGURES = ("frame_ms", "energy", "transistors", "memory_bits")  # those that the table has


def read_grid(file):
    """[(field, values)], and {values: figures}."""
    rows = [row for row in rows_of(file) if row["paper"] == "0"]
    fields = [name for name in rows[0] if name not in (*FIGURES, "front", "paper", "breaks", "command")]
    parameters = [(name, sorted({row[name] for row in rows}, key=lambda text: (len(text), text))) for name in fields]
    return parameters, {tuple(row[name] for name in fields): [float(row[name]) for name in FIGURES if name in row]
                        for row in rows}


def scaled(figures, of):
    """Each figure to 0..1 by the grid's least and greatest, after of()."""
    ranges = [(min(map(of, each)), max(map(of, each))) for each in zip(*figures)]
    return lambda point: tuple((of(value) - low) / (high - low) for value, (low, high) in zip(point, ranges))


def share(grid, found, of=math.log):
    """The part of the grid's hypervolume that is found."""
    scale = scaled(list(grid.values()), of)

    def volume(points):
        points = list({scale(point) for point in points})
        return hypervolume([point for point, on in zip(points, on_front(points)) if on], [1.0] * len(points[0]))
    return volume(found) / volume(grid.values())


def searched(parameters, grid, seed, count):
    """Figures of the configurations that a search of `count` measures."""
    found = {}

    def measure(proposed):
        for point in proposed:
            found[tuple(point.values())] = grid[tuple(point.values())]
        return [(grid[tuple(point.values())], []) for point in proposed]
    assert search(parameters, count, seed, measure) and len(found) == count
    return list(found.values())


def main():
    parameters, grid = read_grid(sys.argv[1])
    count = len(grid) // 5 - 1  # the paper's card is a run too
    tried = [searched(parameters, grid, seed, count) for seed in range(1, int(sys.argv[2]) + 1)]
    chance = [random.Random(seed).sample(list(grid.values()), count) for seed in range(1, int(sys.argv[2]) + 1)]
    print(f"{count} of {len(grid)} configurations, {len(tried)} seeds:")
    for name, of in (("logarithms", math.log), ("figures", float)):
        for who, all_of in (("search", tried), ("by chance", chance)):
            shares = [share(grid, each, of) for each in all_of]
            print(f"{name}, {who}: mean {statistics.mean(shares):.4f}, worst {min(shares):.4f}, "
                  f"{sum(each < 0.95 for each in shares)} below 0.95", flush=True)


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    print(f"grid: {pathlib.Path(sys.argv[1])}")
    main()
