"""Seeds faults into the sources of one room and counts which of them the room's tests see
(docs/contributing/mutants.md)."""
import argparse
import concurrent.futures
import csv
import hashlib
import json
import os
import pathlib
import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import namedtuple

import mutants

ROOT = pathlib.Path(__file__).resolve().parent.parent
TABLES = ROOT / "docs/contributing/mutants"
TREE = ROOT / "out/mutate/source"
BUILD = ROOT / "out/mutate/build"

Room = namedtuple("Room", "folders programs")
ROOMS = {
    "datapath": Room(["board_emu/datapath"], ["datapath_test", "board_test", "routines_test",
                                              "lighting_accuracy_test"]),
    "asic": Room(["board_emu/asic", "board_emu/asic/*"], ["asic_parts_test", "dram_test", "machine_test"]),
    "firmware": Room(["board_emu/firmware", "board_emu/firmware/*", "board_emu/plug_ins"],
                     ["board_test", "lighting_rays_test", "routines_test",
                      "lighting_accuracy_test", "memory_error_test"]),
    "bus": Room(["board_emu/board/bus", "board_emu/server/bus"], ["board_test", "bus_server_test", "server_flags_test",
                                                                    "management_test", "tls_test", "limits_test"]),
    "transport": Room(["driver/src/transport"], ["link_test", "tls_test", "reopen_test", "board_api_test"]),
    "upload": Room(["driver/src/encode", "driver/src/encode/volume"], ["upload_test"]),
    "light": Room(["samples/apps/light/transport"], ["transport_test", "path_tracing_test", "photon_map_test",
                                                      "light_program_test"]),
    "form_factors": Room(["samples/apps/form_factors/exchange", "samples/apps/form_factors/radiosity"],
                         ["form_factors_test", "form_factors_program_test"]),
    "cone_beam": Room(["samples/apps/cone_beam", "samples/apps/cone_beam/phantom"], ["cone_beam_test"]),
    "formats": Room(["driver/scene/formats"], ["scene_files_test"]),
    "cycle": Room(["board_emu/cycle"], ["machine_test", "asic_parts_test", "bit_exactness_test", "board_test",
                                        "accumulator_memory_test", "checkpoint_test"]),
}

Test = namedtuple("Test", "program name seconds reached")
MAX_MUTANTS = mutants.MAX_NUMBER // len(ROOMS)
FIELDS = ["file", "line", "kind", "code", "mutant", "result", "test", "judgement"]
UNSEEN = ("unseen", "not reached")


def say(text):
    print(text, flush=True)


def sources(room):
    return sorted(path.relative_to(ROOT).as_posix() for folder in room.folders for path in ROOT.glob(folder + "/*")
                  if path.suffix in (".h", ".cpp"))


def mark(source):
    """The first line of a mutated file: of which source."""
    return f'#include "{TREE / "mutant.h"}"  // {hashlib.sha1(source).hexdigest()}\n'.encode()


def copy_tree():
    """The working copy as it is. Files that are the same keep their time, and so do those with another room's mutants:
    they are switched off, and their objects need not be compiled again."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True,
                            text=True).stdout.split("\n")
    names = {name for name in listed if name and (ROOT / name).is_file()}
    for name in names:
        to = TREE / name
        source = (ROOT / name).read_bytes()
        there = to.read_bytes() if to.exists() else b""
        if there != source and not there.startswith(mark(source)):
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, to)
    for path in TREE.rglob("*"):
        if path.is_file() and path.name != "mutant.h" and path.relative_to(TREE).as_posix() not in names:
            path.unlink()


def configure():
    # Little optimisation: what is compiled once runs a few hundred times. No warnings: mutants have many.
    subprocess.run(["cmake", "-S", TREE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DGICUBE_UNITY=ON",
                    "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", "-DCMAKE_CXX_FLAGS_RELEASE=-O1 -DNDEBUG",
                    "-DCMAKE_CXX_FLAGS=-w"],
                   check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", BUILD, "--target", "gicube_generated"], check=True, stdout=subprocess.DEVNULL)


def parse_options(top):
    """The compiler options of a source below `top`, for clang."""
    options = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        if "/CMakeFiles/" not in entry["command"] or f" -o {top}" not in entry["command"]:
            continue
        words = shlex.split(entry["command"])
        for i, word in enumerate(words):
            if word == "-isystem":
                options[word + words[i + 1]] = True
            elif word[:2] in ("-I", "-D") or word.startswith("-std="):
                options[word] = True
    # clang 14 has C++20 coroutines, but neither libstdc++ 12 nor Asio 1.74 knows how it says so.
    return list(options) + ["-D__cpp_impl_coroutine=201902L", "-DBOOST_ASIO_HAS_CO_AWAIT=1",
                            "-DBOOST_ASIO_HAS_STD_COROUTINE=1", "-fcoroutines-ts"]


def find(room):
    found = {}
    for name in sources(room):
        finder = mutants.Finder(str(ROOT / name), name, parse_options(name.split("/")[0]))
        for line, error in sorted(finder.errors)[:3]:
            say(f"mutate: clang: {name}:{line}: {error}")
        found[name] = finder
    return found


def drop(found, chosen, wrong):
    """Takes the mutants out that stand on the lines `wrong`, {(file, line)}. False if there is none."""
    out = [number for number, m in chosen.items()
           if any(m.file == file and m.line <= line <= m.line + found[m.file].source[m.begin:m.end].count(b"\n")
                  for file, line in wrong)]
    for number in out:
        say(f"mutate: does not compile: {chosen[number].file}:{chosen[number].line}: {chosen[number].text}")
        del chosen[number]
    return bool(out)


def written(found, chosen, name):
    mine = {number: m for number, m in chosen.items() if m.file == name}
    finder = found[name]
    return mutants.write(finder.source, mine, finder.constexpr, mark(finder.source)) if mine else finder.source


def build(found, chosen, programs, jobs):
    """Builds the programs with the chosen mutants {number: Mutant}; takes out those that do not compile."""
    if not (TREE / "mutant.h").exists() or (TREE / "mutant.h").read_text() != mutants.HEADER:
        (TREE / "mutant.h").write_text(mutants.HEADER)
    for name in sorted({m.file for m in chosen.values()}):  # by clang first, which costs a second
        drop(found, chosen, {(name, line) for line in found[name].wrong_lines(written(found, chosen, name))})
    targets = [word for program in programs for word in ("--target", program)]
    while True:
        for name in found:
            text = written(found, chosen, name)
            if (TREE / name).read_bytes() != text:
                (TREE / name).write_bytes(text)
        made = subprocess.run(["cmake", "--build", BUILD, f"-j{jobs}", *targets, "--", "-k", "0"], capture_output=True,
                              text=True)
        if made.returncode == 0:
            return
        # The first line is the header's; a mutant takes the lines of what it replaces.
        wrong = {(os.path.relpath(os.path.abspath(BUILD / file), TREE), int(line) - 1)
                 for file, line in re.findall(r"^(\S+?):(\d+):\d+: error:", made.stdout, re.M)}
        if not drop(found, chosen, wrong):
            sys.exit("mutate: it does not build\n" + "\n".join(
                line for line in made.stdout.split("\n") if "error" in line or "FAILED" in line)[:4000])


def run(program, names, number=0, reached=None, cpu=600.0, wall=600.0):
    """Runs tests of a program up to the first that fails. Returns the name of that one, "" for none; and its end: pass,
    fail, crash or hang."""
    environment = dict(os.environ, GICUBE_MUTANT=str(number), GICUBE_ALL_SEEDS="1")
    if reached:
        environment["GICUBE_MUTANTS_REACHED"] = reached
    limit = max(1, int(cpu + 0.999))
    with tempfile.TemporaryFile() as log:
        process = subprocess.Popen(
            [BUILD / "tests" / program, "--gtest_fail_fast", "--gtest_color=no", "--gtest_filter=" + ":".join(names)],
            stdout=log, stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL, env=environment, start_new_session=True,
            preexec_fn=lambda: (resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1)),
                                resource.setrlimit(resource.RLIMIT_CORE, (0, 0))))
        try:
            code = process.wait(wall)
        except subprocess.TimeoutExpired:
            code = None
        try:
            os.killpg(process.pid, signal.SIGKILL)  # boards that its tests started, too
        except ProcessLookupError:
            pass
        process.wait()
        log.seek(0)
        text = log.read().decode("utf-8", "replace")
    if code == 0:
        return "", "pass"
    failed = re.findall(r"^\[  FAILED  \] ([\w/]+\.[\w/]+)", text, re.M) or re.findall(r"^\[ RUN      \] (\S+)", text,
        re.M)[-1:]
    name = failed[0] if failed else ""
    if code is None or code == -signal.SIGXCPU:
        return name, "hang"
    return name, "fail" if code > 0 else "crash"


def measure(programs, longest):
    """Every test that passes within `longest` seconds, quickest first, and the mutants that it comes by."""
    tests, slow = [], 0
    with tempfile.NamedTemporaryFile() as file:
        for program in programs:
            listed = subprocess.run([BUILD / "tests" / program, "--gtest_list_tests"], check=True, capture_output=True,
                                    text=True).stdout
            suite, names = "", []
            for line in listed.split("\n"):
                if re.match(r"\S+\.", line):
                    suite = line.split()[0]
                elif line.startswith("  "):
                    names.append(suite + line.split()[0])
            for name in names:
                if "DISABLED_" in name:
                    continue
                file.seek(0)
                file.write(bytes(mutants.MAX_NUMBER))
                file.flush()
                begin = os.times()
                _, end = run(program, [name], reached=file.name, cpu=longest)
                spent = os.times()
                seconds = spent.children_user + spent.children_system - begin.children_user - begin.children_system
                if end == "hang":
                    slow += 1
                    continue
                if end != "pass" and run(program, [name])[1] != "pass":
                    sys.exit(f"mutate: {name} of {program} fails without a mutant")
                file.seek(0)
                tests.append(Test(program, name, seconds,
                                  {i for i, b in enumerate(file.read(mutants.MAX_NUMBER)) if b}))
    say(f"mutate: {len(tests)} tests, {sum(t.seconds for t in tests):.0f} s together; {slow} of more than {longest} s "
        f"are left out")
    return sorted(tests, key=lambda t: t.seconds)


def judge(number, tests):
    """Result and test of one mutant."""
    mine = [t for t in tests if number in t.reached]
    if not mine:
        return "not reached", ""
    begin = 0
    for up_to in (0.05, 0.3, 1e9):  # in few processes, but quick tests first
        batch = [t for t in mine[begin:] if t.seconds <= up_to]
        begin += len(batch)
        for program in dict.fromkeys(t.program for t in batch):
            here = [t for t in batch if t.program == program]
            usual = sum(t.seconds for t in here)
            name, end = run(program, [t.name for t in here], number, cpu=10 * usual + 2, wall=60 + 60 * usual)
            if end in ("crash", "hang"):
                return end, name
            # A test that fails must do so again: it is the mutant, not the machine.
            again = [name] if name else [t.name for t in here]
            if end == "fail" and run(program, again, number, cpu=10 * usual + 2, wall=60 + 60 * usual)[1] != "pass":
                return "seen", name
    return "unseen", ""


def draw(every, count, seed):
    """An equal number of each kind, as long as there are."""
    dice, piles = random.Random(seed), {kind: [m for m in every if m.kind == kind] for kind in mutants.KINDS}
    for pile in piles.values():
        dice.shuffle(pile)
    out = []
    while len(out) < count and any(piles.values()):
        out += [pile.pop() for pile in piles.values() if pile]
    return out[:count]


def old_rows(table):
    if not table.exists():
        return {}
    with table.open() as file:
        return {key(row): row for row in keyed(csv.DictReader(file))}


def key(row):
    return row["file"], row["kind"], row["code"], row["mutant"], row["place"]


def keyed(rows):
    """Numbers rows that read the same, so that a judgement stays with its mutant when lines move."""
    seen = {}
    for row in rows:
        same = row["file"], row["kind"], row["code"], row["mutant"]
        seen[same] = row["place"] = seen.get(same, 0) + 1
        yield row


def save(table, rows):
    TABLES.mkdir(parents=True, exist_ok=True)
    with table.open("w", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("room", choices=sorted(ROOMS))
    parser.add_argument("--count", type=int, default=110, help="mutants, as many of each kind (%(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (%(default)s)")
    parser.add_argument("--jobs", type=int, default=2,
                        help="sources compiled, and mutants tried, at a time (%(default)s)")
    parser.add_argument("--longest", type=float, default=5, help="leave out tests that take more seconds (%(default)s)")
    parser.add_argument("--again", action="store_true",
                        help="only those that the table has as unseen: after adding a test")
    parser.add_argument("--list", action="store_true", help="print the draw, build nothing more")
    arguments = parser.parse_args()
    room, table = ROOMS[arguments.room], TABLES / (arguments.room + ".csv")

    begin = time.monotonic()
    copy_tree()
    configure()
    found = find(room)
    every = [m for name in sorted(found) for m in found[name].mutants()]
    drawn = draw(every, min(arguments.count, MAX_MUTANTS), arguments.seed)
    first = 1 + MAX_MUTANTS * list(ROOMS).index(arguments.room)  # rooms share the build
    chosen = dict(enumerate(sorted(drawn, key=lambda m: (m.file, m.begin, m.end, m.text)), first))
    code = {number: mutants.without_comments(found[m.file].source[m.begin:m.end].decode()) for number,
            m in chosen.items()}
    say(f"mutate: {len(chosen)} of {len(every)} mutants of {arguments.room}, seed {arguments.seed}")
    if arguments.list:
        for number, m in chosen.items():
            say(f"{m.file}:{m.line}: {m.kind}: {code[number]}  ->  {m.text if m.kind != 'statement' else 'nothing'}")
        return
    build(found, chosen, room.programs, arguments.jobs)
    say(f"mutate: built after {time.monotonic() - begin:.0f} s")

    rows = [{"file": m.file, "line": m.line, "kind": m.kind, "code": code[number],
             "mutant": "" if m.kind == "statement" else m.text, "number": number} for number, m in chosen.items()]
    old = old_rows(table)
    rows = list(keyed(rows))
    for row in rows:
        before = old.get(key(row), {})
        row.update(result=before.get("result", ""), test=before.get("test", ""), judgement=before.get("judgement", ""))
    due = [r for r in rows if not arguments.again or not r["result"] or
           r["result"] in UNSEEN and not r["judgement"].startswith("equivalent")]
    tests = measure(room.programs, arguments.longest)
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for row, (result, test) in zip(due, pool.map(lambda r: judge(r["number"], tests), due)):
            row.update(result=result, test=test)
            save(table, rows)  # so far
            say(f"{result:12s} {row['file']}:{row['line']}: {row['kind']}: {row['code']}  ->  {row['mutant']}  {test}")

    unseen = [r for r in rows if r["result"] in UNSEEN]
    equivalent = [r for r in unseen if r["judgement"].startswith("equivalent")]
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    say(f"mutate: {arguments.room}: {len(rows) - len(unseen)} of {len(rows)} seen, {len(equivalent)} equivalent, "
        f"{len(unseen) - len(equivalent)} unseen; {(spent.ru_utime + spent.ru_stime) / 60:.1f} CPU minutes; "
        f"{table.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
