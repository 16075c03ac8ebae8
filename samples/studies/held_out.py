"""How far the approximate level is from the cycle level, and what each level costs the host, on the scenes and configurations of a
file of pairs. Seconds are the host's for the frame, two threads allowed, the least of four runs, which the levels
take in turns. The cycle level runs again with queues one place shorter: how far it is from itself."""
import pathlib

from studies.runs import Run, RunFolder
from studies.table import csv_text, write_whole

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared/data"
LEVELS = ("functional", "approximate", "cycle")
ROUNDS = 4
COLUMNS = ["pair", "time_error", "hit_ratio", "hit_ratio_error", "bandwidth_gb_s", "bandwidth_error", "bandwidth_error_of_peak", "time_self",
           "bandwidth_self", "functional_time_error", "functional_s", "approximate_s", "cycle_s", "approximate_cpu_s", "cycle_cpu_s", "arguments"]


def pairs_of(file):
    """Name and arguments of each pair, as written and as gicube-render takes them: what begins with @ is in the folder of scans. Those
    whose scans are not there are left out, and said."""
    for line in pathlib.Path(file).read_text().splitlines():
        if line and not line.startswith("#"):
            name, written = line.split(maxsplit=1)
            if "@" in written and not DATA.exists():
                print(f"{name}: no scans, left out")
                continue
            yield name, written, [f"{DATA}/{word[1:]}" if word.startswith("@") else word for word in written.split()]


def queue_rays(arguments):
    given = [word for word in arguments if word.startswith("asic.queue_rays=")]
    return int(given[0].split("=")[1]) if given else 256


def measured(folder, render, arguments):
    """Statistics of each level, and of the cycle level with a place less; what the folder has is not run again."""
    def stats(number, *more):
        runs, run = RunFolder(folder / str(number)), Run([*arguments, *more, "--threads", "2"])
        if not runs.has(run):
            runs.carry_out(run, render)
        return runs.read(run)
    rounds = [[stats(number, "--fidelity", level) for level in LEVELS] for number in range(ROUNDS)]
    least = [min(runs, key=lambda each: each["host_seconds"]) for runs in zip(*rounds)]
    return *least, stats(0, "--fidelity", "cycle", "--set", f"asic.queue_rays={queue_rays(arguments) - 1}")


def row_of(name, written, functional, approximate, cycle, other):
    def off(of, key):
        return of[key] / cycle[key] - 1
    channels = sum(1 for key in cycle["counters"] if key.startswith("rdram") and key.endswith(".reads") and key != "rdram.reads")
    peak = 1.6 * max(1, channels)  # GB/s: 800 MHz, 16 bits
    return [name, off(approximate, "frame_ms"), cycle["hit_ratio"], approximate["hit_ratio"] - cycle["hit_ratio"], cycle["memory_gb_s"],
            off(approximate, "memory_gb_s"), (approximate["memory_gb_s"] - cycle["memory_gb_s"]) / peak, off(other, "frame_ms"),
            off(other, "memory_gb_s"), off(functional, "frame_ms"), functional["host_seconds"], approximate["host_seconds"], cycle["host_seconds"],
            approximate["host"]["board_cpu_s"], cycle["host"]["board_cpu_s"], written]


def measure(pairs, folder, render, out):
    """Writes the table, after each pair what there is of it."""
    rows = [COLUMNS]
    for name, written, arguments in pairs_of(pairs):
        row = row_of(name, written, *measured(folder, render, arguments))
        rows.append([f"{value:.5g}" if isinstance(value, float) else value for value in row])
        write_whole(out, csv_text(rows))
        print(f"{name:26} time {row[1]:+.2%}, hit ratio {row[3]:+.4f}, bandwidth {row[5]:+.2%} (itself {row[8]:+.2%}), "
              f"{row[12] / row[11]:.1f} times faster", flush=True)
