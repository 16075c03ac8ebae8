"""gicube-explore: its space, its search against an exhaustive grid, and the program as its users run it, on pictures of
a few pixels."""
import csv
import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys

import pytest

pytest.importorskip("optuna")
from studies import explore, search, space  # noqa: E402
from studies.hardware_cost import hardware_cost  # noqa: E402
from studies.runs import InputError, RunFolder  # noqa: E402
from studies.table import on_front  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(1, str(HERE))
import explore_grid  # noqa: E402

BIN = pathlib.Path(os.environ["GICUBE_BIN_DIR"])
SMALL = """
scenes = ["builtin:buckyball"]
[fields]
"asic.processors" = [1, 2, 4]
"asic.block_voxels" = [8, 16]
"memory" = ["rdram", "ddr"]
[fix]
volume-size = 16
size = "16x16"
fidelity = "cycle"
"asic.max_volume_voxels" = 32
"""


# ---- space


def read(folder, text):
    (folder / "space.toml").write_text(text)
    return space.read_space(folder / "space.toml")


def test_a_space_has_scenes_beside_it_and_texts_for_values(tmp_path):
    of = read(tmp_path, 'scenes = ["builtin:buckyball", "a.scene"]\nconstraints = ["power <= 25 '
                        'W"]\n[fields]\n"asic.processors" = [1, 2]\n'
              '[fix]\njitter = true\nstep = 0.5\n')
    assert of.scenes == ["builtin:buckyball", str(tmp_path / "a.scene")]
    assert of.objectives == ["frame_ms", "energy", "transistors", "memory_bits"]
    assert of.parameters == [("asic.processors", ["1", "2"])] and of.fixed == [("jitter", "on"), ("step", "0.5"),
        ("threads", "1")]
    assert of.constraints[0].holds(25) and not of.constraints[0].holds(25.1) and of.constraints[0].worst([1, 3]) == 3


@pytest.mark.parametrize("text, why", [
    ("scenes = 3", "scenes: expected a list, got 3"), ("scene = []", "scene: expected one of scenes"),
    ("[fields", "a TOML file"),
    ("scenes = ['builtin:buckyball']", "fields: expected at least one"),
    (SMALL.replace("asic.processors", "step"), "step: expected a field of the board's configuration"),
    (SMALL.replace("[1, 2, 4]", "[1, 1]"), "asic.processors: expected each value once"),
    (SMALL + "frames = 2", "fix: frames: expected a parameter that is not set elsewhere"),
    ("objectives = ['frame_ms']" + SMALL, "objectives: expected at least two"),
    ("constraints = ['power < 25 mW']" + SMALL, "power < 25 mW: expected the unit W, got mW"),
    ("constraints = ['power = 25']" + SMALL, "constraints: expected NAME < NUMBER")])
def test_what_is_wrong_with_a_space_is_named(tmp_path, text, why):
    with pytest.raises(InputError, match=re.escape(why)):
        read(tmp_path, text)


# ---- figures


def test_energy_is_in_joules_and_power_over_the_pictures_time_and_both_may_be_absent():
    with_energy = {"frame_ms": 2.0, "counters": {"energy.total": {"value": 5e9, "unit": "pJ"}}}
    assert explore.figure_of("energy", with_energy, {}) == pytest.approx(5e-3, rel=1e-12)
    assert explore.figure_of("power", with_energy, {}) == pytest.approx(2.5, rel=1e-12)
    assert math.isnan(explore.figure_of("power", {"frame_ms": 2.0, "counters": {}}, {}))
    assert space.mean([1, 100]) == pytest.approx(10, rel=1e-12) and math.isnan(space.mean([1, math.nan]))


def test_the_paper_cards_costs_are_those_of_its_table():
    cost = hardware_cost(BIN / "gicube-board")
    assert cost.memory_bits == 33554432 + 15828928  # [P Table 1]: docs/guide/observation.md
    assert 9.35e6 < cost.transistors < 9.45e6 and cost.pins == 4 * 34


def test_a_front_in_many_figures_leaves_out_what_another_dominates():
    assert on_front([(1, 9, 9), (9, 1, 9), (9, 9, 1), (9, 9, 9), (1, 9, 9), (0, 0, math.nan)]) == [True, True, True,
        False, True, False]


# ---- search


def test_the_hypervolume_is_that_of_another_program():
    import numpy
    from optuna._hypervolume import WFG
    chance = random.Random(5)
    for dimensions in (2, 3, 4):
        points = [[chance.random() * 1.1 for _ in range(dimensions)] for _ in range(20)]
        inside = numpy.array([point for point in points if max(point) < 1])
        assert search.hypervolume(points,
                                  [1.0] * dimensions) == pytest.approx(WFG().compute(inside, numpy.ones(dimensions)),
                                      rel=1e-12)
    assert search.hypervolume([(0.5, 0.5), (0.25, 0.75)], (1, 1)) == 0.25 + 0.25 * 0.25


@pytest.mark.parametrize("seed", [1, 2])
def test_a_fifth_of_a_grids_runs_finds_nearly_all_of_its_hypervolume(seed):
    parameters, grid = explore_grid.read_grid(HERE / "explore_grid.csv")
    assert len(grid) == 300
    found = explore_grid.searched(parameters, grid, seed, 59)
    assert explore_grid.share(grid, found) >= 0.95 and explore_grid.share(grid, found, float) >= 0.95


def test_a_search_is_the_same_again_and_goes_through_a_small_space_once():
    parameters = [("a", ["1", "2", "3"]), ("b", ["1", "2", "3", "4"])]

    def tried(count):
        asked = []

        def measure(proposed):
            asked.extend(tuple(each.values()) for each in proposed)
            return [None if each == {"a": "1", "b": "1"} else ([int(each["a"]) + 1, 9 - int(each["b"])],
                [int(each["b"]) > 3]) for each in proposed]
        assert search.search(parameters, count, 7, measure)
        return asked
    assert tried(11) == tried(11) and len(set(tried(11))) == len(tried(11)) == 12
    assert len(tried(12)) == 12


# ---- the program


def run(folder, arguments, text=SMALL):
    (folder / "space.toml").write_text(text)
    return subprocess.run(f"{BIN}/gicube-explore space.toml {arguments}", shell=True, cwd=folder,
                          stdin=subprocess.DEVNULL, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)


def runs(folder):
    return {file.name: file.stat().st_mtime_ns for file in (folder / "out/runs").glob("*.json")}


def test_a_front_a_chart_and_the_command_for_each_point(tmp_path):
    done = run(tmp_path, "-o out --points 4 --chart --jobs 2")
    assert done.returncode == 0, done.stderr
    whole = json.loads((tmp_path / "out/explore.json").read_text())
    assert len(whole["points"]) == 5 and whole["points"][0]["paper"] and any(point["front"]
        for point in whole["points"])
    assert whole["objectives"] == ["frame_ms", "energy", "transistors", "memory_bits"]
    assert all(5 < point["energy"] / (point["frame_ms"] * 1e-3) < 25 for point in whole["points"])  # watts
    assert "the paper's card" in (tmp_path / "out/explore.svg").read_text() and "the paper's card" in done.stdout
    rows = list(csv.DictReader((tmp_path / "out/explore.csv").read_text().splitlines()))
    assert len(rows) == 5 and rows[0]["paper"] == "1" and "--set memory=" in rows[1]["command"]
    subprocess.run(rows[1]["command"], shell=True, check=True, cwd=tmp_path, stdout=subprocess.DEVNULL,
                   env=os.environ | {"PATH": f"{BIN}:{os.environ['PATH']}"})
    assert json.loads((tmp_path / "run.json").read_text())["frame_ms"] == pytest.approx(float(rows[1]["frame_ms"]),
        rel=1e-5)

    # Again after a kill: only what is lost is run.
    before, table = runs(tmp_path), (tmp_path / "out/explore.csv").read_bytes()
    lost = next(iter(before))
    (tmp_path / "out/runs" / lost).unlink()
    assert run(tmp_path, "-o out --points 4 --jobs 2").returncode == 0
    after = runs(tmp_path)
    assert {name for name in before if before[name] != after[name]} == {lost} and (tmp_path /
        "out/explore.csv").read_bytes() == table


def test_power_is_a_constraint(tmp_path):
    done = run(tmp_path, "-o out --points 3", 'constraints = ["power < 25 W", "power < 1 W"]' + SMALL)
    assert done.returncode == 0, done.stderr
    points = json.loads((tmp_path / "out/explore.json").read_text())["points"]
    assert all(point["breaks"] == ["power < 1 W"] for point in points)


def test_shards_do_each_run_once_and_round_by_round_come_to_the_same_table(tmp_path):
    (tmp_path / "whole").mkdir()
    assert run(tmp_path / "whole", "-o out --points 4 --quiet").returncode == 0
    said = []
    for _ in range(2):  # the paper's card with the first round, as shard 1 begins; then what shard 1 left
        said = [run(tmp_path, f"-o out --points 4 --shard {i}/2 --jobs 1").stdout for i in (1, 2)]
        assert not (tmp_path / "out/explore.csv").exists()
    assert all("the search is at its end" in each for each in said)
    before = runs(tmp_path)
    assert run(tmp_path, "-o out --points 4 --quiet").returncode == 0 and runs(tmp_path) == before
    assert (tmp_path / "out/explore.csv").read_bytes() == (tmp_path / "whole/out/explore.csv").read_bytes()


def test_constraints_over_several_scenes_are_marked_or_cost_no_run(tmp_path):
    (tmp_path / "ball.scene").write_text('volume { builtin: "buckyball" size: 16 }\n')
    text = SMALL.replace('["builtin:buckyball"]',
                         '["builtin:buckyball", "ball.scene"]\nconstraints = ["frame_ms < 0.0001 ms", "transistors < '
                         '4e6"]')
    done = run(tmp_path, "-o out --points 4 --jobs 2", text)
    assert done.returncode == 0, done.stderr
    whole = json.loads((tmp_path / "out/explore.json").read_text())
    assert all("frame_ms < 0.0001 ms" in point["breaks"] and not point["front"] for point in whole["points"])
    assert all(point["transistors"] < 4e6 for point in whole["points"] if not point["paper"])
    assert all(each["why"] == "transistors < 4e6" for each in whole["refused"])
    assert whole["points"][1]["command"].startswith("gicube-sweep builtin:buckyball ball.scene --fix ")
    assert len(runs(tmp_path)) == 2 * 5


def test_what_can_not_be_measured_is_an_error_and_named(tmp_path):
    done = run(tmp_path, "-o out --points 1", 'objectives = ["frame_ms", "nothing"]' + SMALL)
    assert done.returncode == 1 and done.stderr.startswith(
        "gicube-explore: nothing: expected a number in the run's statistics")
    done = run(tmp_path, "-o out --points 13")
    assert (done.returncode == 1
            and done.stderr == "gicube-explore: --points: expected 1 to 12, the configurations of the space, got 13\n")
    functional = SMALL.replace('"cycle"', '"functional"')
    done = run(tmp_path, "-o out --points 1", functional)
    assert done.returncode == 1 and "energy: expected counter energy.total in the run's statistics" in done.stderr
    assert run(tmp_path, "").returncode == 2


def test_a_configuration_that_the_board_refuses_is_listed_and_not_run(tmp_path):
    done = run(tmp_path, "-o out --points 2 --quiet", SMALL.replace("[1, 2, 4]", "[1, 99]"))
    assert done.returncode == 0, done.stderr
    whole = json.loads((tmp_path / "out/explore.json").read_text())
    assert whole["refused"] and all("asic.processors" in each["why"]
                                    for each in whole["refused"]) and len(whole["points"]) == 3
