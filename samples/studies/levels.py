"""Simulated time that the functional level omits, and the host's cost of both levels, for the scenes and configurations
of samples/studies/level_pairs.txt: pictures with their light, and cone-beam scans. Seconds are processor time of the
program and its board with one thread, in one run per level. Runs in the folder are reused."""
import json
import pathlib
import re
import resource
import shlex

from studies.runs import run_to_end
from studies.table import csv_text, write_whole

ROOT = pathlib.Path(__file__).resolve().parents[2]
DATA = ROOT.parent / "shared/data"
LEVELS = ("functional", "cycle")
COLUMNS = ["pair", "functional_time_error", *(f"{level}_s" for level in LEVELS), "command"]


def pairs_of(file):
    """Name, program, arguments to make its input, and measured arguments. Words with @ are in the folder of scans;
    reports and omits pairs without their scans."""
    for line in pathlib.Path(file).read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        name, program, command = line.split(maxsplit=2)
        if "@" in command and not DATA.exists():
            print(f"{name}: no scans, left out")
            continue
        before, _, measured = command.rpartition(";")
        yield name, program, before.strip(), measured.strip()


def board_ms(stats):
    """Simulated time of all commands of a picture with its light, or of a scan."""
    if "frame_ms" in stats:
        return stats["frame_ms"] + sum(each["pass_ms"] for each in stats["lighting"] or [])
    return stats["board_ms"]


def processor_seconds():
    """Times of all finished programs, with their boards."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measured(folder, programs, name, program, before, command):
    """Statistics and seconds by level."""
    work = folder / name
    work.mkdir(parents=True, exist_ok=True)
    binary = f"{programs}/gicube-{program}"
    if before and not (work / "made").exists():
        run_to_end(binary, [*shlex.split(before.format(work=work)), "--quiet"], work / "before.log")
        (work / "made").touch()
    found = {}
    for level in LEVELS:
        stats, seconds = work / f"{level}.json", work / f"{level}.s"
        if not seconds.exists():
            output = work / ("out.png" if program == "render" else "out.nrrd")
            before_it = processor_seconds()
            run_to_end(binary, [*shlex.split(re.sub(r"(^| )@", rf"\1{DATA}/", command).format(work=work)), "--fidelity",
                                level,
                                "--threads", "1", "--quiet", "--stats", str(stats), "-o", str(output)],
                       work / f"{level}.log")
            seconds.write_text(str(processor_seconds() - before_it))
        found[level] = json.loads(stats.read_text()), float(seconds.read_text())
    return found


def measure(pairs, folder, programs, out):
    """Writes the table, and after each pair the finished part of it."""
    rows = [COLUMNS]
    for name, program, before, command in pairs_of(pairs):
        found = measured(pathlib.Path(folder), programs, name, program, before, command)
        (functional, quick), (cycle, slow) = (found[level] for level in LEVELS)
        left_out = board_ms(functional) / board_ms(cycle) - 1
        rows.append([name, *(f"{value:.5g}" for value in (left_out, quick, slow)), f"{program} {command}"])
        write_whole(out, csv_text(rows))
        print(f"{name:26} functional: time {left_out:+.2%}, {slow / quick:.1f} times faster", flush=True)
