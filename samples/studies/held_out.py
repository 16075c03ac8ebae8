"""How far the approximate level is from the cycle level, and what each level costs the host, on the scenes and configurations of a
file of pairs: pictures with their light, and cone-beam scans. Seconds are those of the processor, of the program and its board with one
thread, of one run. The cycle level runs again with queues one place shorter: how far it is
from itself."""
import pathlib
import re

from studies import sampled
from studies.table import csv_text, write_whole

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared/data"
LEVELS = {level: ("--fidelity", level) for level in ("functional", "approximate", "cycle")}
COLUMNS = ["pair", "time_error", "cycles_error", "packets_error", "hit_ratio", "hit_ratio_error", "time_self", "packets_self", "functional_time_error",
           "answered", "functional_s", "approximate_s", "cycle_s", "command"]


def pairs_of(file):
    """Pairs as series_of() has them. A word that begins with @ is in the folder of scans; pairs whose scans are not there are left out,
    and said."""
    for name, program, before, command in sampled.series_of(file):
        if "@" in command and not DATA.exists():
            print(f"{name}: no scans, left out")
            continue
        yield name, program, before, command


def queue_rays(command):
    given = re.search(r"asic\.queue_rays=(\d+)", command)
    return int(given[1]) if given else 256


def row_of(name, command, found):
    """Of a board that the approximate level refuses, the cycle level's."""
    refused = "approximate" not in found
    found = {"approximate": found["cycle"]} | found
    functional, approximate, cycle, shorter = (found[way][0] for way in (*LEVELS, "self"))
    seen, expected, other = (sampled.sums(stats) for stats in (approximate, cycle, shorter))

    def hit_ratio(sums):
        return 1 - sums["missed_voxels"] / (8 * sums["checks"])

    def time_of(stats):
        return sampled.board_ms(stats) / sampled.board_ms(cycle) - 1

    def off(sums, key):
        return max(1, sums[key]) / max(1, expected[key]) - 1
    return [name, time_of(approximate), off(seen, "cycles"), off(seen, "packets"), hit_ratio(expected), hit_ratio(seen) - hit_ratio(expected),
            time_of(shorter), off(other, "packets"), time_of(functional), "refused" if refused else "cycle" if seen["by_cycle_level"] else "approximate", *(found[way][1] for way in LEVELS), command]


def measure(pairs, folder, programs, out):
    """Writes the table, after each pair what there is of it."""
    rows = [COLUMNS]
    for name, program, before, command in pairs_of(pairs):
        ways = LEVELS | {"self": (*LEVELS["cycle"], "--set", f"asic.queue_rays={queue_rays(command) - 1}")}
        there = re.sub(r"(^| )@", rf"\1{DATA}/", command)
        row = row_of(name, f"{program} {command}", sampled.measured(pathlib.Path(folder), programs, name, program, before, there, ways, 1))
        rows.append([f"{value:.5g}" if isinstance(value, float) else value for value in row])
        write_whole(out, csv_text(rows))
        print(f"{name:26} time {row[1]:+.2%} (cycles {row[2]:+.2%}), packets {row[3]:+.2%} (itself {row[7]:+.2%}), hit ratio {row[5]:+.4f}, "
              f"{row[12] / row[11]:.1f} times faster, answered: {row[9]}", flush=True)
