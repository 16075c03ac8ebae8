"""The programs of samples/python do what they say; they and the package hold mypy's strict rules."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from conftest import ball

import gicube

matplotlib.use("Agg")
ROOT = Path(__file__).parents[3]
SAMPLES = ROOT / "samples/python"


def program(name):
    spec = importlib.util.spec_from_file_location(name, SAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_each_program_has_a_test():
    here = Path(__file__).read_text()
    names = {path.stem for path in SAMPLES.glob("*.py")} - {"conftest"}
    assert {name for name in names if f'"{name}' not in here} == set()


def test_first_picture(tmp_path, capsys):
    gicube.write_volume(tmp_path / "scan.nrrd", ball())
    program("first_picture").main(str(tmp_path / "scan.nrrd"), "ramp", str(tmp_path / "a.png"))
    assert "ms of simulated time" in capsys.readouterr().out
    assert (tmp_path / "a.png").stat().st_size > 1000


def test_heat_map(tmp_path):
    module = program("heat_map")
    module.PROCESSORS, module.QUEUE_RAYS = [1, 4], [16, 256]
    assert module.time_of(1, 16) > module.time_of(4, 256)
    module.main(str(tmp_path / "a.png"))
    assert (tmp_path / "a.png").stat().st_size > 1000


def test_deadline_test():
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(SAMPLES / "deadline_test.py")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and "5 passed" in done.stdout, done.stdout


def test_tomography(tmp_path):
    module = program("tomography")
    few, more = module.main(str(tmp_path / "a.png"), 1), module.main(str(tmp_path / "a.png"), 4)
    assert more < 0.8 * few and more < 0.08


def test_visibility():
    found = program("visibility").main()
    assert found[0, 1] == 1 and found[2, 3] == 0  # through the door, and not through the wall
    assert (found == found.T).all()


def test_ambient_occlusion(tmp_path):
    shades = program("ambient_occlusion").main(str(tmp_path / "a.png"), 16)
    seen = shades[~np.isnan(shades)]
    assert 0.2 < len(seen) / shades.size < 0.95
    assert seen.min() < 0.6 and seen.max() > 0.95


@pytest.mark.parametrize("what", ["driver/python/gicube", "samples/python"])
def test_types_are_strict(what, tmp_path):
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", str(Path(__file__).with_name("mypy.ini")), "--cache-dir", str(tmp_path)]
    command.append(str(ROOT / what))
    done = subprocess.run(command, capture_output=True, text=True, env={"MYPYPATH": str(ROOT / "driver/python"), "PATH": "/usr/bin"})
    assert done.returncode == 0, done.stdout


def test_charts_of_counters():
    import gicube.plot

    setup = gicube.parse_scene('volume { builtin: "buckyball" size: 32 } image { width: 32 height: 32 }').set_up()
    with gicube.open("emu:?fidelity=cycle") as board:
        image = board.render(gicube.load_scene(board, setup))
        counters = board.counters
    assert sum(gicube.plot.cycles_by_cause(counters).values()) == pytest.approx(1)
    assert "samples" in [text.get_text().split("\n")[0] for text in gicube.plot.cycles(counters).texts]
    assert gicube.plot.picture(image).images[0].get_array().shape == (32, 32, 3)
