"""Measures the emulator's own speed (host time), and how it compares with the last tagged version on the same machine
in the same run: both are built and run in turns, and each case's ratio is the median over the turns.

  script/bench                                    all but the minutes of cone beam
  script/bench --filter 'demo_frame|host_rays'    some cases: a regular expression
  script/bench --against COMMIT                   compared with another version; --alone: with none
  script/bench --rounds 5 --json FILE             more turns (3); the table as JSON too
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LONG = "-fdk|cone_beam"  # what follows a minus is left out
GOOGLE = ("real_time", "cpu_time", "items_per_second")  # Google Benchmark's own figures; the rest are a case's counters


def run(*command, **rest):
    subprocess.run(command, check=True, cwd=rest.pop("cwd", ROOT), **rest)


def answer(*command):
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    except FileNotFoundError:  # a machine without git
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def build(source, folder):
    quiet = dict(stdout=sys.stderr, cwd=source)
    run("cmake", "--preset", "release", "-B", folder, **quiet)
    run("cmake", "--build", folder, "--target", "gicube_bench", "gicube-board", **quiet)


def build_version(commit):
    """Builds another commit beside this one, and says where."""
    folder = os.path.join(ROOT, "build", "bench", commit)
    source = os.path.join(folder, "source")
    if not os.path.isdir(source):
        run("git", "worktree", "prune")
        run("git", "worktree", "add", "--force", "--detach", source, commit, stdout=sys.stderr)
    build(source, folder)
    return folder


def measure(folder, cases):
    """Seconds of each case, what it says it does a second, and what else it counts."""
    with tempfile.NamedTemporaryFile(suffix=".json") as out:
        environment = dict(os.environ, GICUBE_BOARD=os.path.join(folder, "bin", "gicube-board"))
        run(os.path.join(folder, "tests", "gicube_bench"), f"--benchmark_filter={cases}", f"--benchmark_out={out.name}",
            "--benchmark_out_format=json", env=environment, stdout=subprocess.DEVNULL)
        unit = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}
        results = json.load(open(out.name)).get("benchmarks", [])
    return {r["name"]: (r["real_time"] * unit[r["time_unit"]], r.get("items_per_second"),
                        {k: v for k, v in r.items() if isinstance(v, float) and k not in GOOGLE})
            for r in results if "error_occurred" not in r}


def scaled(value, suffix):
    if value is None:
        return ""
    for factor, prefix in ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1, ""), (1e-3, "m"), (1e-6, "u")):
        if value >= factor:
            return f"{value / factor:.3g} {prefix}{suffix}"
    return f"{value / 1e-9:.3g} n{suffix}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--filter", default=LONG)
    parser.add_argument("--against", help="a commit; the last tag if nothing is said")
    parser.add_argument("--alone", action="store_true")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json")
    options = parser.parse_args()

    name = None if options.alone else options.against or answer("git", "describe", "--tags", "--abbrev=0", "HEAD")
    commit = name and answer("git", "rev-parse", "--short", f"{name}^{{commit}}")
    if options.against and not commit:
        sys.exit(f'bench: --against: expected a commit, got "{options.against}"')
    if not commit and not options.alone:
        print("bench: this repository has no tag to compare with (--against COMMIT)", file=sys.stderr)
    here = os.path.join(ROOT, "build", "release")
    build(ROOT, here)
    before = build_version(commit) if commit else None

    now_runs, before_runs = [], []
    for number in range(options.rounds):
        print(f"bench: round {number + 1} of {options.rounds}", file=sys.stderr, flush=True)
        if before:
            before_runs.append(measure(before, options.filter))
        now_runs.append(measure(here, options.filter))
    if not now_runs[0]:
        sys.exit(f'bench: --filter: expected a name of a case, got "{options.filter}"')

    table = []
    for case in now_runs[0]:
        rates = [r[case][1] for r in now_runs if r[case][1] is not None]
        row = {"case": case, "seconds": statistics.median(r[case][0] for r in now_runs),
               "per_second": statistics.median(rates) if rates else None, "counters": now_runs[-1][case][2]}
        pairs = [(b[case][0], n[case][0]) for b, n in zip(before_runs, now_runs) if case in b]
        if pairs:
            ratios = [old / new for old, new in pairs]
            row |= {"faster": statistics.median(ratios), "least": min(ratios), "most": max(ratios)}
        table.append(row)

    width = max(len(row["case"]) for row in table)
    heading = f"faster than {name} ({commit}), of {options.rounds} rounds" if commit else ""
    print(f"{'case':{width}}  {'time':>9}  {'a second':>9}  {heading}")
    for row in table:
        ratio = f"x{row['faster']:.2f}  ({row['least']:.2f} to {row['most']:.2f})" if "faster" in row else ""
        if commit and not ratio:
            ratio = "not there before"
        counters = "".join(f"  {name}={value:.4g}" for name, value in row["counters"].items())
        print(f"{row['case']:{width}}  {scaled(row['seconds'], 's'):>9}  {scaled(row['per_second'], ''):>9}  "
              f"{ratio}{counters}")
    if options.json:
        with open(options.json, "w") as file:
            json.dump({"against": commit, "rounds": options.rounds, "cases": table}, file, indent=2)


main()
