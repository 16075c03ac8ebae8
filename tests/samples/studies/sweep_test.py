"""gicube-sweep: its parts, and the program as its users run it, on pictures of a few pixels."""
import argparse
import contextlib
import csv
import json
import math
import os
import pathlib
import re
import resource
import shutil
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest

from studies import runs, sensitivity, sweep
from studies.pictures import resized, rmse
from studies.runs import InputError, Run, figure

BIN = os.environ["GICUBE_BIN_DIR"]
SMALL = "builtin:buckyball --fix volume-size=32 --fix size=24x24 --vary step=0.5,1,2 --reference step=0.25 -o out"


# ---- parameters


def test_a_parameter_has_values_between_commas_or_if_they_have_commas_between_semicolons():
    assert sweep.parse_parameter("step=0.5,1") == ("step", ["0.5", "1"])
    assert sweep.parse_parameter("eye=0,-3,0;1,2,3") == ("eye", ["0,-3,0", "1,2,3"])
    assert sweep.parse_parameter("asic.processors=4") == ("asic.processors", ["4"])


@pytest.mark.parametrize("text, why", [("step", "NAME=VALUE"), ("=3", "NAME=VALUE"), ("step=", "NAME=VALUE"),
                                       ("--step=1", "NAME=VALUE"),
                                       ("step=1,,2", "step: expected values"), ("step=1,2,1", '"1" twice')])
def test_a_parameter_is_refused_by_what_is_wrong_with_it(text, why):
    with pytest.raises(argparse.ArgumentTypeError, match=why):
        sweep.parse_parameter(text)


def test_a_grid_has_every_combination_once_and_the_last_parameter_varies_fastest():
    points = sweep.grid([("a", ["1", "2"]), ("b", ["x", "y", "z"])])
    assert len(points) == 6 and points[0] == {"a": "1", "b": "x"} and points[4] == {"a": "2", "b": "y"}
    assert sweep.grid([]) == [{}]


def test_a_point_becomes_the_arguments_of_gicube_render():
    point = {"step": "0.5", "input": "builtin:buckyball", "jitter": "on", "no-leap": "off", "asic.processors": "8"}
    assert sweep.arguments_of(point) == ["builtin:buckyball", "--step", "0.5", "--jitter", "--set", "asic.processors=8"]
    # Changed entries keep their place, new ones come last.
    changed = {"a": "1", "b": "2"} | {"b": "3", "c": "4"}
    assert list(changed.items()) == [("a", "1"), ("b", "3"), ("c", "4")]


def test_every_option_of_the_help_is_understood():
    every = ("a --vary=x=1 --vary y=2,3 -oout --chart b --fix u=1 --fix v=w --reference x=3 --cost c --error e --also "
             "f --also g --also-error h "
             "--name n --title t --jobs 3 --shard 2/3 --quiet c -- -d --version")
    given = sweep.options_of(every.split())
    assert given.parameters == [("input", ["a", "b", "c", "-d", "--version"]), ("x", ["1"]), ("y", ["2", "3"])]
    assert given.fixed == [("u", "1"), ("v", "w"), ("threads", "1")] and given.reference == [("x", "3")]
    assert (given.cost, given.error, given.also, given.also_errors, given.name, given.title) == ("c", "e", ["f", "g"],
        ["h"], "n", "t")
    assert given.folder == pathlib.Path("out") and given.jobs == 3 and given.shard == (2,
        3) and given.chart and given.quiet
    given = sweep.options_of("a --output out --reference-picture /etc/passwd --fix threads=2".split())
    assert given.reference_picture == "/etc/passwd" and given.fixed == [("threads",
        "2")] and given.parameters == [("input", ["a"])]
    assert (given.cost, given.error, given.name, given.title, given.jobs) == ("frame_ms", "picture", "sweep", None, 0)
    assert not given.chart and not given.quiet and not given.reference and not given.also and not given.also_errors
    assert not given.sensitivity and sweep.options_of("a -o out --sensitivity".split()).sensitivity
    named = set(re.findall("--[a-z-]+", every)) | {"--help", "--output", "--reference-picture", "--sensitivity"}
    assert set(re.findall(r"^  (?:-\w,)?(--[a-z-]+)", sweep.parser_of_options().format_help(), re.MULTILINE)) == named


# ---- rows and tables


def row(cost, error, is_reference=False, also=(), **point):
    return SimpleNamespace(point=point or {"step": f"{cost:f}"}, cost=float(cost),
                           error=math.nan if is_reference else float(error), also=list(also), on_front=False,
                           is_reference=is_reference, run=Run(["a b", "--step", "1"]))


def test_the_front_has_the_rows_that_no_other_is_cheaper_and_better_than():
    rows = [row(1, 9), row(2, 5), row(2, 7), row(3, 5), row(4, 1), row(5, 2), row(6, 0, True)]
    sweep.mark_front(rows)
    assert [each.on_front for each in rows] == [True, True, False, False, True, False, True]
    rows.append(row(2.5, 0, True))  # has no error, and is cheaper
    sweep.mark_front(rows)
    assert [each.on_front for each in rows] == [True, True, False, False, False, False, False, True]
    equal = [row(1, 1), row(1, 1)]
    sweep.mark_front(equal)
    assert equal[0].on_front and equal[1].on_front


def test_a_table_is_one_line_a_row_with_its_command_and_the_same_in_json(monkeypatch):
    monkeypatch.setattr(sweep, "version", lambda: "9.9")
    options = SimpleNamespace(cost="frame_ms", error="picture", also=["bus_ms"], also_errors=[])
    rows = [row(2, 0.25, also=[7.0]), row(9, 0, True, also=[math.nan])]
    sweep.mark_front(rows)
    command = "gicube-render 'a b' --step 1 -o picture.exr --stats run.json"
    assert sweep.table_text(options, rows) == ("frame_ms,error picture,front,reference,bus_ms,step,command\n"
                                               f"2,0.25,1,0,7,2.000000,{command}\n9,,1,1,,9.000000,{command}\n")
    read = json.loads(sweep.json_text(options, rows, "gicube-sweep x"))
    assert len(read["points"]) == 2 and read["front"] == read["points"]  # the reference has no error
    assert read["front"][0] == {"settings": {"step": "2.000000"}, "frame_ms": 2, "error picture": 0.25, "bus_ms": 7,
                                "reference": False,
                                "front": True, "command": command}
    assert read["points"][1]["error picture"] is None and read["points"][1]["bus_ms"] is None
    assert read["provenance"] == {"program": "gicube-sweep", "version": "9.9", "command": "gicube-sweep x"}
    assert ',"1,2,3",' in sweep.table_text(options, [row(1, 1, also=[7.0], eye="1,2,3")])


def test_a_setting_changes_the_cost_by_the_largest_difference_between_rows_that_share_the_others():
    rows = [row(cost, 0, step=step, jitter=jitter) for step, jitter,
            cost in (("1", "off", 10), ("2", "off", 12), ("1", "on", 30), ("2", "on", 33))]
    assert sweep.cost_change(rows, "step") == pytest.approx(0.2, abs=1e-12)
    assert sweep.cost_change(rows, "jitter") == pytest.approx(2, abs=1e-12)


# ---- runs


def test_a_figure_is_a_name_or_a_pointer_and_nothing_else():
    statistics = {"frame_ms": 3.5, "counters": {"bus.up": {"value": 7}}, "throughput": None,
                  "lighting": [{"host_seconds": 2}], "on": True}
    assert figure(statistics, "frame_ms") == 3.5
    assert figure(statistics, "/counters/bus.up/value") == 7
    assert figure(statistics, "/lighting/0/host_seconds") == 2
    for name in ("throughput", "frames", "/counters/x", "/lighting/1/host_seconds", "on"):
        with pytest.raises(InputError,
                           match=f"^{name}: expected a number in the run's statistics, got none of that name$"):
            figure(statistics, name)


def test_a_run_is_named_by_its_arguments_and_by_the_state_of_its_file(tmp_path):
    one, same, other = (Run(["builtin:buckyball", "--step", step]) for step in "112")
    assert one.key() == same.key() != other.key()
    file = tmp_path / "a.scene"
    file.write_text("x")
    before = Run([str(file)]).key()
    os.utime(file, ns=(1, 1))
    assert Run([str(file)]).key() != before
    assert Run(["my scan.nrrd", "--cut",
                "1,0,0,3"]).command() == "gicube-render 'my scan.nrrd' --cut 1,0,0,3 -o picture.exr --stats run.json"
    assert runs.quoted("it's") == "'it'\\''s'"


def test_after_a_failure_no_run_starts_and_results_stay(tmp_path):
    folder = runs.RunFolder(tmp_path / "runs")
    program = tmp_path / "program"
    program.write_text('#!/bin/sh\n[ "$1" != bad ] || { echo whole; echo reason; echo; exit 3; }\necho >"$3"; echo {} '
                       '>"$5"\n')
    program.chmod(0o755)
    each = [Run([name]) for name in ("good", "bad", "late")]
    told = []

    @contextlib.contextmanager
    def meter(total):
        told.append(total)
        yield SimpleNamespace(update=lambda: told.append("done"))
    with pytest.raises(runs.RunFailed,
                       match="^gicube-render bad -o picture.exr --stats run.json\n  exit code 3: reason$"):
        runs.carry_out_all(folder, each, program, 1, meter)
    assert folder.has(each[0]) and not folder.has(each[1]) and told == [3, "done"]
    assert not list((tmp_path / "runs").glob("*.part.*"))
    with pytest.raises(runs.RunFailed, match="No such file"):
        runs.carry_out_all(folder, [Run(["other"])], tmp_path / "none", 1, meter)


# ---- pictures


def flat(width, height, value):
    return np.full((height, width, 4), value, dtype=np.float32)


def test_errors_of_pictures_are_root_mean_squares_of_all_channels():
    picture = flat(2, 2, 0.5)
    assert rmse(picture, flat(2, 2, 0.5)) == 0
    picture[0, 1, 1] = 0.9
    assert rmse(picture, flat(2, 2, 0.5)) == pytest.approx(0.4 / 4, abs=1e-7)


def test_a_picture_of_another_size_is_resized_to_the_reference():
    small = flat(2, 1, 0)
    small[0, 1] = 1
    large = resized(small, 4, 2)
    assert large.shape == (2, 4, 4)
    np.testing.assert_allclose(large[:, :, 0], [[0, 0.25, 0.75, 1]] * 2, atol=1e-6)
    assert rmse(small, large) == pytest.approx(0, abs=1e-6)


# ---- the program


class Program:
    def __init__(self, folder):
        self.folder = folder

    def run(self, arguments, **more):
        done = subprocess.run(f"{BIN}/gicube-sweep {arguments}", shell=True, cwd=self.folder, stdin=subprocess.DEVNULL,
                              text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False, **more)
        self.out, self.err = done.stdout, done.stderr
        return done.returncode

    def text(self, file):
        return (self.folder / file).read_text()

    def json(self):
        return json.loads(self.text("out/sweep.json"))

    def runs(self):
        return {file: file.stat().st_mtime_ns for file in (self.folder / "out/runs").glob("*.json")}


@pytest.fixture
def program(tmp_path):
    return Program(tmp_path)


def test_cost_and_error_of_every_combination_and_the_front_are_written(program):
    assert program.run(f"{SMALL} --vary jitter=off,on --also bus_ms --jobs 2") == 0, program.err
    read = program.json()
    assert len(read["points"]) == 6 and read["front"]
    assert all(point["frame_ms"] > 0 and point["bus_ms"] > 0 for point in read["points"])
    errors = {point["settings"]["step"]: point["error picture"]
              for point in read["points"] if point["settings"]["jitter"] == "off"}
    assert errors["2"] > 1.5 * errors["0.5"]
    assert "gicube-render builtin:buckyball --step 2 --jitter --volume-size 32" in program.text("out/sweep.csv")
    assert "of 6 runs" in program.out
    assert read["provenance"]["command"].startswith("gicube-sweep builtin:buckyball --fix volume-size=32")
    assert f"gicube-sweep {read['provenance']['version']}\n" == subprocess.check_output([f"{BIN}/gicube-sweep",
        "--version"], text=True)


def test_a_functional_boards_frame_time_hardly_knows_the_step_and_it_says_so(program):
    assert program.run(f"{SMALL} --fix fidelity=functional") == 0, program.err
    assert "note: step changes frame_ms by at most " in program.err and "--fix fidelity=cycle" in program.err
    assert program.run(f"{SMALL} --fix fidelity=functional --cost samples") == 0, program.err
    assert "note:" not in program.err
    assert program.run(f"{SMALL} --fix fidelity=cycle") == 0, program.err
    assert "note:" not in program.err


def test_a_figure_that_no_run_has_is_warned_of(program):
    assert program.run(f"{SMALL} --also bus_ms --also buss_ms") == 0, program.err
    assert "warning: --also buss_ms: no run has a number of that name\n" in program.err
    assert "--also bus_ms" not in program.err


def test_a_sweep_says_in_how_many_pictures_nothing_is_visible(program):
    grid = "builtin:buckyball --fix volume-size=32 --fix size=24x24 --vary 'cut=1,0,0,900;1,0,0,8;0,1,0,900' -o out"
    assert program.run(grid) == 0, program.err
    assert program.err.endswith(
        "note: nothing is visible in the picture: all that is visible is cut away: 2 of 3 runs\n")


def test_a_sweep_goes_on_where_a_killed_one_was(program):
    assert program.run(SMALL) == 0, program.err
    table, before = program.text("out/sweep.csv"), program.runs()
    assert len(before) == 4
    # As if it had been killed within a run: no result, and what the run had begun to write.
    lost = next(iter(before))
    lost.unlink()
    lost.with_suffix(".part.json").write_text("{")
    assert program.run(SMALL) == 0, program.err
    assert program.text("out/sweep.csv") == table  # simulated time is the same again
    after = program.runs()
    assert {file: after[file] for file in before if file != lost} == {file: time for file,
        time in before.items() if file != lost}


def test_no_part_of_a_chart_is_left_on_a_full_disk(program):
    """The runs are there; what there is room for is the tables, but not the chart."""
    assert program.run(f"{SMALL} --chart") == 0, program.err
    chart = program.text("out/sweep.svg")
    assert "Pareto front" in chart and "</svg>" in chart
    assert len(chart) > 2 * len(program.text("out/sweep.json"))
    for name in ("sweep.svg", "sweep-cost.svg"):
        (program.folder / "out" / name).unlink()
    limit = len(chart) // 2
    assert program.run(f"{SMALL} --chart", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE,
        (limit, limit))) == 1
    assert "sweep.svg: file: expected a place to write to, got File too large" in program.err
    assert not [file for file in (program.folder / "out").iterdir() if "svg" in file.name]


def test_a_rows_command_makes_its_figures_again(program):
    assert program.run(SMALL) == 0, program.err
    point = program.json()["front"][0]
    subprocess.run(point["command"], shell=True, check=True, cwd=program.folder, stdout=subprocess.DEVNULL,
                   env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"})
    assert json.loads(program.text("run.json"))["frame_ms"] == point["frame_ms"]


def test_one_picture_may_be_the_reference_of_all(program):
    picture = "builtin:buckyball --volume-size 32 --size 40x40 -o exact.exr --quiet"
    subprocess.run(f"{BIN}/gicube-render {picture}", shell=True, check=True, cwd=program.folder)
    grid = "builtin:buckyball --fix volume-size=32 --vary size=20x20,40x40 --reference-picture"
    assert program.run(f"{grid} exact.exr -o out --quiet") == 0, program.err
    small, same = (point["error picture"] for point in program.json()["points"])
    assert same == 0 and 0.01 < small < 0.2
    assert program.out == ""
    assert program.run(f"{grid} out/sweep.csv -o out --quiet") == 1
    assert "out/sweep.csv: picture: expected an image that can be read, got OpenImageIO" in program.err


def test_one_warm_board_serves_a_grid_of_configurations(program):
    scene = "builtin:buckyball --fidelity cycle --volume-size 32 --size 24x24"
    subprocess.run(f"{BIN}/gicube-render {scene} --quiet -o a.png --checkpoint-at frame=0 --checkpoint warm",
                   shell=True, check=True,
                   cwd=program.folder)
    grid = ("builtin:buckyball --fix volume-size=32 --fix size=24x24 --fix restore=warm --reference bus.model=pci33 -o "
            "out")
    assert program.run(f"{grid} --vary bus.model=pci33,agp4x "
                       f"--vary sorter.policy=most_rays,longest_wait") == 0, program.err
    points = program.json()["points"]
    times = {(each["settings"]["bus.model"], each["settings"]["sorter.policy"]): each["frame_ms"] for each in points}
    assert len(times) == 4 and all(times["pci33", policy] > times["agp4x", policy]
                                   for policy in ("most_rays", "longest_wait"))
    assert {point["error picture"] for point in points if not point["reference"]} == {0}
    assert program.run(f"{grid} --vary asic.processors=4,2") == 1
    assert "asic.processors: expected 4, as in the checkpoint, got 2" in program.err


def test_no_row_of_the_table_is_cheaper_and_better_than_what_is_printed(program):
    """A run that is its own reference has no error: it beats all that cost more."""
    grid = "builtin:buckyball --fix volume-size=32 --fix size=24x24 --fix fidelity=cycle -o out --cost frame_ms"
    assert program.run(f"{grid} --vary step=0.5,1 --vary asic.processors=1,4 --reference asic.processors=4 --error "
                       f"samples") == 0, program.err
    table = [(float(row["frame_ms"]), float(row["error samples"] or 0))
             for row in csv.DictReader(program.text("out/sweep.csv").splitlines())]
    printed = [line.split() for line in program.out.splitlines()[1:]]
    assert len(table) == 4 and printed
    for cost, error, *_ in printed:
        cost, error = float(cost), 0 if error == "reference" else float(error)
        assert not [row for row in table if row[0] <= cost and row[1] <= error and row != (cost, error)]
    assert min(cost for cost, error in table if error == 0) == float(printed[0][0])


def test_cost_alone_needs_no_reference_and_its_chart_has_what_there_is(program):
    grid = "builtin:buckyball --fix volume-size=32 --fix size=24x24 --vary dsp.clock_khz=100000,200000 -o out --chart"
    assert program.run(grid) == 0, program.err
    slow, fast = csv.DictReader(program.text("out/sweep.csv").splitlines())
    assert float(slow["frame_ms"]) > float(fast["frame_ms"])
    assert (slow["front"], fast["front"], slow["error picture"], slow["reference"]) == ("0", "1", "", "0")
    assert program.out.splitlines()[0].split() == "frame_ms of 2 runs, no other is cheaper:".split()
    assert program.out.splitlines()[1].split()[:2] == [fast["frame_ms"],
                                                       "gicube-render"] and len(program.out.splitlines()) == 2
    assert len(program.runs()) == 2 and "dsp.clock_khz" in program.text("out/sweep.svg")
    # Runs without error have a place too: beside others below them, or alone at 0.
    for reference, names in (("dsp.clock_khz=200000", ["no error", "Pareto front"]),
                             ("threads=1", ["no error", "Pareto front"])):
        assert program.run(f"{grid} --reference {reference} --error frame_ms") == 0, program.err
        assert all(name in program.text("out/sweep.svg") for name in names)
        assert "dsp.clock_khz" in program.text("out/sweep-cost.svg")


def test_a_failed_run_is_named_with_its_command_and_reason(program):
    assert ((((program.run("builtin:buckyball --fix volume-size=32 --vary asic.processors=2,99 --reference step=1 -o "
                           "out") == 1))))
    assert "--set asic.processors=99" in program.err and "exit code 2: gicube-board: asic.processors" in program.err
    assert program.run("builtin:buckyball --fix volume-size=32 --cost nothing --reference step=1 -o out") == 1
    assert program.err == "gicube-sweep: nothing: expected a number in the run's statistics, got none of that name\n"
    assert program.run("builtin:buckyball --reference step=1 -o /dev/null/x") == 1
    assert program.err == "gicube-sweep: /dev/null/x/runs: folder: expected one that can be made, got Not a directory\n"


# ---- sensitivity


@pytest.mark.parametrize("value, legal, expected", [
    (16, "1..256 core cycles", [17, 15]), (256, "1..256 dwords", [254]),
    (200000, "1000..2000000 kHz", [202000, 198000]),
    (0, "0..4096 rays", [1]), (0, "0..1 (0 or 1)", []), (2, "1, 2, 4 or 8 ways", [4, 1]),
    (288, "144 or 288 Mbit", [144]), (3, "1.. messages", [4, 2]), (1024, "1..16384 (2^-14 voxels)", [1034, 1014])])
def test_a_number_goes_to_the_nearest_legal_ones(value, legal, expected):
    assert sensitivity.stepped(value, legal) == expected


EXPLAINED = """\
asic.processors                  4              1..16 processors              paper: four
dsp.clock_khz                    200000         1000..2000000 kHz             chosen: a C62x
bus.model                        pci33                                        chosen: a name is no number
pipeline.prefetch_stages         16             1..256 core cycles            chosen: half
memory                           ddr                                          default rdram: paper
link.bits                        32             1..256 bits                   \
not modelled at this level; default 16: chosen: wide
rdram.rac_latency                4              0..255 tCYCLE                 chosen: one
ddr.controller_latency           2              0..255 clocks                 default 1: chosen: one
"""


def test_of_a_level_those_numbers_are_taken_that_are_chosen_and_that_it_models():
    found = sensitivity.chosen_numbers(EXPLAINED)
    assert [name for name, *_ in found] == ["dsp.clock_khz", "pipeline.prefetch_stages", "ddr.controller_latency"]
    assert found[0] == ("dsp.clock_khz", 200000, "1000..2000000 kHz")


def test_prices_of_energy_are_stepped_only_for_a_cost_of_energy():
    explained = """memory                           ddr            """ + """            paper
energy.ddr_read_fj               21900000       0..4000000000 fJ              derived: a data sheet, give or take 25%
energy.logic_aj                  1500           0..4000000000 aJ              chosen: half of 6 fF, give or take 50%
"""
    assert sensitivity.chosen_numbers(explained) == []
    assert [row[0] for row in sensitivity.chosen_numbers(explained, True)] == ["energy.ddr_read_fj", "energy.logic_aj"]


def test_the_sensitivity_of_a_run_is_what_its_steps_do_to_the_frame(program):
    small = ("builtin:buckyball --fix volume-size=32 --fix size=24x24 --fix fidelity=cycle --fix asic.block_voxels=8 "
             "-o out --jobs 2")
    assert program.run(f"{small} --sensitivity") == 0, program.err
    rows = program.json()["sensitivity"]
    by_name = {row["number"]: row for row in rows}
    assert {"dsp.clock_khz", "pipeline.prefetch_stages", "link.bits", "rdram.t_rtr",
            "sdram.controller_latency"} <= by_name.keys()
    assert not any(name.startswith(("ddr.", "ideal.", "asic.")) for name in by_name)
    known = [(row["scatter"], -abs(row["elasticity"])) for row in rows if row["elasticity"] is not None]
    assert known == sorted(known) and any(key < 0 for _, key in known)
    clock = by_name["dsp.clock_khz"]
    assert clock["value"] == 200000 and [step["to"] for step in clock["steps"]] == [198000, 202000]
    for step in clock["steps"]:
        subprocess.run(step["command"], shell=True, check=True, cwd=program.folder, stdout=subprocess.DEVNULL,
                       env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"})
        assert json.loads(program.text("run.json"))["frame_ms"] == pytest.approx(clock["frame_ms"] + step["change"],
            abs=1e-9)
    lines = program.out.splitlines()
    assert lines[1].split()[:2] == ["chosen",
                                    "number"] and lines[2].split()[0] == rows[0]["number"] and len(lines) == len(
                                        rows) + 2
    assert len(program.text("out/sweep.csv").splitlines()) == sum(len(row["steps"]) for row in rows) + 1


def test_a_slope_goes_over_both_steps_and_changes_in_one_direction_are_scatter():
    def row(value, to, costs):
        return sensitivity.finish(SimpleNamespace(name="a", value=value, to=to), 10, costs)
    slope = row(100, [99, 101], [10.1, 9.7])
    assert slope.elasticity == pytest.approx(-2) and not slope.is_scatter
    assert row(100, [101], [10.2]).elasticity == pytest.approx(2)
    assert row(100, [99, 101], [10.1, 10.3]).is_scatter and not row(100, [99, 101], [10, 10.3]).is_scatter
    assert math.isnan(row(0, [1], [11]).elasticity) and row(0, [1], [11]).changes == [1]


def test_a_quicker_dsp_takes_off_its_own_share_of_a_functional_frame(program):
    assert program.run("builtin:buckyball --fix volume-size=32 --fix size=24x24 --fix fidelity=functional -o out "
                       "--sensitivity") == 0, program.err
    by_name = {row["number"]: row for row in program.json()["sensitivity"]}
    assert -1 < by_name["dsp.clock_khz"]["elasticity"] < 0 and not by_name["dsp.clock_khz"]["scatter"]
    # that one is a limit, as at all levels
    assert {name.split(".")[0] for name in by_name if name != "sdram.ranks"} == {"dsp", "bus"}


def test_the_functional_level_reads_none_of_the_messages_that_are_left_out(program):
    """Their fields change no frame time there."""
    def frame(more):
        command = (f"{BIN}/gicube-render builtin:buckyball --volume-size 32 --size 24x24 --quiet -o a.png --stats "
                   f"a.json {more}")
        subprocess.run(command, shell=True, check=True, cwd=program.folder)
        return json.loads(program.text("a.json"))["frame_ms"]
    others = ("cache.miss_packets=40 link.bits=64 pipeline.prefetch_stages=20 rdram.rac_latency=9 "
              "sdram.controller_latency=9")
    assert frame("") == frame(" ".join(f"--set {each}" for each in others.split()))
    assert frame("") != frame("--set dsp.clock_khz=150000")


def test_a_board_that_runs_already_has_no_sensitivity(program):
    assert program.run("builtin:buckyball --fix volume-size=32 --fix board=unix:/none -o out --sensitivity") == 1
    assert "board: expected none with --sensitivity, whose boards are private" in program.err


@pytest.mark.parametrize("arguments, why", [
    ("b -o out --vary step=1 --error frame_ms", "--error: expected with --reference, got none"),
    ("b -o out --vary step=1 --also-error frame_ms", "--also-error: expected with --reference, got none"),
    ("b -o out --vary step=1 --fix step=2 --reference step=1",
     "step: expected once among INPUT, --vary and --fix, got it twice"),
    ("b -o out --vary output=a,b --reference step=1", "output: expected another parameter, it is the sweep's own"),
    ("-o out", "INPUT is required"),
    ("a b -o out --sensitivity", "--sensitivity: expected one INPUT and none of --vary"),
    ("b -o out --sensitivity --reference step=1", "--sensitivity: expected one INPUT and none of --reference"),
    ("b", "the following arguments are required: -o/--output"),
    ("b -o", "argument -o/--output: expected one argument"),
    ("b -o out -o in", "argument -o/--output: expected once, got it twice"),
    ("b -o out --jobs 1025", 'argument --jobs: expected a number from 0 to 1024, got "1025"'),
    ("b -o out --shard 3/2", 'argument --shard: expected I/N with 1 <= I <= N, as 2/8, got "3/2"'),
    ("b -o out --sensitivity --shard 1/2", "--sensitivity: expected one INPUT and none of --shard"),
    ("b -o out --xyz 3 --varry=step=1 --fixx a=b",
     "--xyz: no such option; --varry: no such option, the nearest is --vary; "
     "--fixx: no such option, the nearest is --fix"),
    ("b -o out --reference-picture none.exr", 'argument --reference-picture: expected a file, got "none.exr"'),
    ("b -o out --reference-picture /", 'argument --reference-picture: expected a file, got "/"'),
    ("b -o out --reference-picture /etc/passwd --reference step=1",
     "--reference: expected without --reference-picture, got both"),
    ("b -o out --reference-picture /etc/passwd --error frame_ms",
     '--error: expected picture with --reference-picture, got "frame_ms"'),
    ("b -o out --reference-picture /etc/passwd --also-error x",
     "--also-error: expected with --reference, got --reference-picture")])
def test_what_is_wrong_with_the_command_line_is_named(program, arguments, why):
    assert program.run(arguments) == 2
    assert program.err == f"gicube-sweep: {why}\n"


def test_a_link_to_the_program_finds_the_others_and_a_full_disk_of_its_output_is_an_error(program):
    (program.folder / "link").symlink_to(shutil.which("gicube-sweep", path=BIN))
    said = subprocess.check_output([program.folder / "link", "--version"], text=True)
    assert said == subprocess.check_output([pathlib.Path(BIN) / "gicube-render", "--version"],
                                           text=True).replace("render", "sweep")
    assert program.run("--help > /dev/full") == 1
    assert program.err == "gicube-sweep: standard output: No space left on device\n"
