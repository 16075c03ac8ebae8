"""The programs of samples/python do what they say; they and the package hold mypy's strict rules."""

import importlib.util
import re
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
GUIDE = re.findall(r"```python\n(.*?)```", (ROOT / "docs/guide/python.md").read_text(), re.DOTALL)


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


def test_pre_classified(tmp_path):
    image = program("pre_classified").main(str(tmp_path / "a.png"), 32)
    assert (tmp_path / "a.png").stat().st_size > 1000
    seen = image.pixels["alpha"] > 4000
    red, green = (image.pixels["rgb"][seen][:, c].astype(int) for c in (0, 1))
    assert (red > 2 * green).sum() > 100, "flesh in the wedge"
    assert (green > red + 20).sum() > 1000, "skin"


def test_heat_map(tmp_path):
    module = program("heat_map")
    module.PROCESSORS, module.QUEUE_RAYS = [1, 4], [16, 256]
    assert module.time_of(1, 16) > module.time_of(4, 256)
    module.main(str(tmp_path / "a.png"))
    assert (tmp_path / "a.png").stat().st_size > 1000


def test_fork():
    module = program("fork")
    module.EDGE, module.FORKS = 24, [("pci33", "most_rays"), ("agp4x", "longest_wait")]
    times = module.main()
    assert times["pci33", "most_rays"] > times["agp4x", "longest_wait"] > 0


def test_deadline_test():
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(SAMPLES / "deadline_test.py")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0 and "5 passed" in done.stdout, done.stdout


def test_tomography(tmp_path):
    module = program("tomography")
    few, more = module.main(str(tmp_path / "a.png"), 1), module.main(str(tmp_path / "a.png"), 4)
    assert more < 0.8 * few and more < 0.08


def test_own_method():
    module = program("own_method")
    few, more = module.main(10), module.main(30)
    assert more < 0.6 * few and more < 0.1


def test_visibility():
    found = program("visibility").main()
    assert found[0, 1] == 1 and found[2, 3] == 0  # through the door, and not through the wall
    assert (found == found.T).all()


def test_ambient_occlusion(tmp_path):
    shades = program("ambient_occlusion").main(str(tmp_path / "a.png"), 16)
    seen = shades[~np.isnan(shades)]
    assert 0.2 < len(seen) / shades.size < 0.95
    assert seen.min() < 0.6 and seen.max() > 0.95


def test_the_guides_programs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    gicube.write_volume("head.nrrd", ball() * 10.0)
    for text in GUIDE:
        exec(compile(text, "docs/guide/python.md", "exec"), {})
    assert len(GUIDE) == 2
    for made in ("head.png", "loads.png"):
        assert (tmp_path / made).stat().st_size > 500


def test_types_are_strict(tmp_path):
    for i, text in enumerate(GUIDE):
        (tmp_path / f"guide_{i}.py").write_text(text)
    command = [sys.executable, "-m", "mypy", "--strict", "--config-file", str(Path(__file__).with_name("mypy.ini")),
               "--cache-dir", str(tmp_path)]
    command += map(str, (ROOT / "driver/python/gicube", SAMPLES, *tmp_path.glob("guide_*.py")))
    done = subprocess.run(command, capture_output=True, text=True,
                          env={"MYPYPATH": str(ROOT / "driver/python"), "PATH": "/usr/bin"})
    assert done.returncode == 0, done.stdout


def test_charts_of_counters():
    import gicube.plot

    setup = gicube.parse_scene('volume { builtin: "buckyball" size: 32 } image { width: 32 height: 32 }').set_up()
    with gicube.open("emu:?fidelity=cycle") as board:
        image = board.render(gicube.load_scene(board, setup))
        counters = board.counters
    assert sum(gicube.plot.cycles_by_cause(counters).values()) == pytest.approx(1)
    assert "samples" in [text.get_text().split("\n")[0] for text in gicube.plot.cycles(counters).texts]
    joules = gicube.plot.energy_by_part(counters)
    assert sum(value for value, _, _ in joules.values()) == pytest.approx(counters["energy.total"] * 1e-12)
    assert all(low <= value <= high for value, low, high in joules.values())
    bar = gicube.plot.energy(counters).patches
    assert len(bar) == 7 and all(a.get_x() + a.get_width() == pytest.approx(b.get_x()) for a, b in zip(bar, bar[1:]))
    assert sum(part.get_width() for part in bar) == pytest.approx(counters["energy.total"] * 1e-9)
    assert gicube.plot.picture(image).images[0].get_array().shape == (32, 32, 3)


def test_loads_over_time_come_from_a_boards_trace(tmp_path):
    import gicube.plot

    setup = gicube.parse_scene('volume { builtin: "buckyball" size: 32 } image { width: 32 height: 32 }').set_up()
    trace = tmp_path / "trace.json"
    with gicube.open(f"emu:?fidelity=cycle&set=asic.block_voxels=8&trace={trace}") as board:
        view = gicube.load_scene(board, setup)
        begin, before = board.now, board.counters
        board.render(view)
        end, seen = board.now, board.counters - before
    found = gicube.plot.loads_over_time(trace)
    assert {"processor 3 rays waiting", "links rays on links"} <= set(found)
    packets = [each for name, each in found.items() if name.startswith("memory")]
    assert len(packets) > 1 and all(begin <= times[0] and times[-1] <= end for times, values in packets)
    read = sum((values[:-1] * np.diff(times)).sum() for times, values in packets) * 1e-6  # of whole microseconds
    assert read == pytest.approx(seen["rdram.reads"], rel=0.1)
    queues, memories = gicube.plot.loads(trace)
    assert len(queues.get_yticks()) == 4 and len(memories.get_yticks()) == len(packets)
    assert memories.images[0].get_array().max() > 0
    # one block: three processors have nothing to do, and are shown
    with gicube.open(f"emu:?fidelity=cycle&trace={trace}") as board:
        board.render(gicube.load_scene(board, setup))
    busy, *idle = gicube.plot.loads(trace)[0].images[0].get_array()
    assert busy.max() > 0 and len(idle) == 3 and not np.any(idle)
    (tmp_path / "empty.json").write_text("[\n]\n")
    with pytest.raises(gicube.BadArgument, match="fidelity=cycle"):
        gicube.plot.loads(tmp_path / "empty.json")


def test_phantoms(tmp_path, capsys):
    program("phantoms").main(str(tmp_path), 96)
    looks = dict(line.split(": transfer function: ") for line in capsys.readouterr().out.splitlines())
    looks = {Path(name).name: why.split(",")[0] for name, why in looks.items()}
    assert looks == {"ct_head.nrrd": "ct-bone", "mri_head.nrrd": "mri-t2", "part.nrrd": "ct-engine",
                     "labels.nrrd": "colours of labels", "cells.nrrd": "colours of labels", "cloud.vdb": "ramp"}
    assert gicube.read_volume(tmp_path / "part.nrrd").dims == (96, 96, 96)
