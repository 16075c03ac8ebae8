"""How far sampled simulation is from the cycle level, whether its intervals hold, and what it costs the host, on the series of commands of
samples/studies/sampled_pairs.txt. Seconds are those of the processor, of the program and its board, of
one run a level. What the folder has is not run again."""
import json
import pathlib
import resource
import shlex

from studies.runs import RunFailed, run_to_end
from studies.table import csv_text, write_whole

ROUNDS = 1
ERROR = "3%"
WAYS = {"functional": ("--fidelity", "functional"), "approximate": ("--fidelity", "approximate"), "cycle": ("--fidelity", "cycle"),
        "sampled": ("--sample", ERROR)}
QUANTITIES = ("cycles", "packets", "missed_voxels")
COLUMNS = ["series", "commands", "simulated", "cycles_error", "cycles_within", "packets_error", "packets_within", "missed_error", "missed_within",
           "approximate_time_error", "approximate_packets_error", "functional_time_error", *(f"{way}_s" for way in WAYS), "command"]


def series_of(file):
    """Name, program, arguments that make its input, and those that are measured."""
    for line in pathlib.Path(file).read_text().splitlines():
        if line and not line.startswith("#"):
            name, program, command = line.split(maxsplit=2)
            before, _, measured = command.rpartition(";")
            yield name, program, before.strip(), measured.strip()


def board_ms(stats):
    """Simulated time of all commands."""
    if "frames" in stats:
        lit = sum(each["pass_ms"] for frame in stats["frames"] for each in frame["lighting"] or [] if not each["reused"])
        return lit + sum(frame["frame_ms"] for frame in stats["frames"])
    if "frame_ms" in stats:
        return stats["frame_ms"] + sum(each["pass_ms"] for each in stats["lighting"] or [])
    return stats["board_ms"]


def processor_seconds():
    """Of all programs that were run, with their boards."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measured(folder, programs, name, program, before, command, ways=WAYS, rounds=ROUNDS):
    """Statistics and seconds by way; those of the approximate level are missing where it does not take the board."""
    work = folder / name
    work.mkdir(parents=True, exist_ok=True)
    binary = f"{programs}/gicube-{program}"
    if before and not (work / "made").exists():
        run_to_end(binary, [*shlex.split(before.format(work=work)), "--quiet"], work / "before.log")
        (work / "made").touch()
    found = {}
    for number in range(rounds):
        for way, options in ways.items():
            stats = work / f"{way}{number}.json"
            if not (work / f"{way}{number}.s").exists():
                output = work / ("out.png" if program == "render" else "out.nrrd")
                arguments = [*shlex.split(command.format(work=work)), *options, "--threads", "1", "--quiet", "--stats", str(stats),
                             *([] if program == "form-factors" else ["-o", str(output)])]
                before_it = processor_seconds()
                try:
                    run_to_end(binary, arguments, work / f"{way}{number}.log")
                except RunFailed:
                    if way != "approximate":
                        raise
                    continue
                (work / f"{way}{number}.s").write_text(str(processor_seconds() - before_it))
            seconds = float((work / f"{way}{number}.s").read_text())
            if way not in found or seconds < found[way][1]:
                found[way] = json.loads(stats.read_text()), seconds
    return found


def sums(stats):
    """What a timed level counted; of one picture also in its lighting passes."""
    value = {}
    for window in [stats, *(each for each in stats.get("lighting") or [] if not each["reused"])]:
        for name, each in window["counters"].items():
            value[name] = value.get(name, 0) + each["value"]
    memory = next(name for name in ("rdram", "ddr") if f"{name}.reads" in value)
    return {"cycles": value["asic.cycles"], "packets": value[f"{memory}.reads"] + value[f"{memory}.writes"],
            "missed_voxels": value["processor.cache.missed_voxels"], "checks": value.get("processor.cache.checks", 0),
            "by_cycle_level": value.get("fidelity_answered.cycle", 0)}


def row_of(name, command, found):
    sampled, cycle = found["sampled"][0]["sampled"], found["cycle"][0]
    row = [name, sampled["commands"], sampled["commands"] - sampled["estimated_commands"]]
    all_ms = board_ms(cycle)
    whole = sums(cycle)
    for quantity in QUANTITIES:
        found_sum, within = sampled[quantity]["sum"], sampled[quantity]["within"]
        row += [found_sum / max(1, whole[quantity]) - 1, within / max(1, found_sum)]
    if "approximate" in found:
        approximate = found["approximate"][0]
        row += [board_ms(approximate) / all_ms - 1, sums(approximate)["packets"] / max(1, whole["packets"]) - 1]
    else:
        row += ["", ""]
    return [*row, board_ms(found["functional"][0]) / all_ms - 1, *(found[way][1] if way in found else "" for way in WAYS), command]


def measure(pairs, folder, programs, out):
    """Writes the table, after each series what there is of it."""
    rows = [COLUMNS]
    for name, program, before, command in series_of(pairs):
        row = row_of(name, f"{program} {command}", measured(pathlib.Path(folder), programs, name, program, before, command))
        rows.append([f"{value:.5g}" if isinstance(value, float) else value for value in row])
        write_whole(out, csv_text(rows))
        holds = abs(row[3]) <= row[4] + 1e-9
        print(f"{name:20} {row[2]} of {row[1]} simulated, cycles {row[3]:+.2%} within {row[4]:.2%}: {'holds' if holds else 'DOES NOT HOLD'}", flush=True)
