"""Speed-up of several boards in one host: the same picture on more boards, and pictures that grow with them."""
import math
import pathlib
import tempfile

from studies.points import Table, run, statistics

BOARDS = {"strong": (1, 2, 4, 8, 16, 32, 64), "weak": (1, 2, 4, 8, 16)}
BUSES = ("own", "shared")
EDGE = {"strong": lambda boards: 512, "weak": lambda boards: round(256 * math.sqrt(boards))}  # pixels


def measured(kind, buses, boards, fidelity="cycle", voxels=128, edge=None):
    """Times of a picture after the first, which loads the tables: its simulated milliseconds, and their parts as means
    over the boards."""
    edge = edge or EDGE[kind](boards)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(folder, "gicube-render",
            f"builtin:buckyball --volume-size {voxels} --size {edge}x{edge} --frames 2 --fidelity {fidelity} --threads "
            f"1 --quiet"
            f" --board emu:?boards={boards}&buses={buses} -o @picture.png --stats @stats.json")
        frame = statistics(folder / "stats.json")["frames"][1]
    each = frame["boards"]["each"] if boards > 1 else [{"work_ms": frame["frame_ms"] - frame["bus_ms"],
                                                        "bus_ms": frame["bus_ms"],
                                                        "bus_wait_ms": 0, "skew_ms": 0}]
    means = {part: sum(board[part] for board in each) / len(each)
             for part in ("work_ms", "bus_ms", "bus_wait_ms", "skew_ms")}
    return {"edge": edge, "frame_ms": frame["frame_ms"], **means}


def rows(found):
    one = {}
    for name, each in found:
        _, kind, buses, boards = name.split("/")
        one.setdefault(buses, each["frame_ms"])  # the first is one board's
        share = one[buses] / each["frame_ms"] / (int(boards) if kind == "strong" else 1)
        yield name, [buses, boards, each["edge"],
                     *(f"{each[part]:.4f}" for part in ("frame_ms", "work_ms", "bus_ms", "bus_wait_ms", "skew_ms")),
                     f"{share:.3f}"]


def tables():
    columns = ["buses", "boards", "edge", "frame_ms", "work_ms", "bus_ms", "bus_wait_ms", "skew_ms", "efficiency"]
    return [Table(f"boards_{kind}", columns,
                  {f"boards/{kind}/{buses}/{boards}": lambda _, of=(kind, buses, boards): measured(*of)
                   for buses in BUSES for boards in BOARDS[kind]},
                  rows) for kind in EDGE]
