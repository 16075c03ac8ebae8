"""gicube-render --mpi, as its users start it: by MPI's own launcher, one process a rank."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest
from PIL import Image

BIN = pathlib.Path(os.environ["GICUBE_BIN_DIR"])
LAUNCHER = os.environ["GICUBE_MPIEXEC"]
SMALL = ("builtin:buckyball --volume-size 64 --size 48x40 --set asic.block_voxels=8 --set asic.max_volume_voxels=64 "
         "--threads 1")
LONG = "builtin:buckyball --volume-size 128 --size 1024x1024 --fidelity cycle --threads 1"


def command(ranks, arguments, program=BIN / "gicube-render"):
    launcher = [LAUNCHER, "-n", str(ranks)] if ranks else []
    return [*launcher, str(program), *arguments.split()]


def run(folder, ranks, arguments):
    return subprocess.run(command(ranks, arguments), cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, timeout=100)


def pixels(file):
    return np.asarray(Image.open(file)).astype(int)


def said_by_program(text):
    return [line for line in text.splitlines() if line.startswith("gicube-render: ")]


@pytest.mark.parametrize("ranks, scene", [
    (1, "--jitter --samples 2"), (3, "--threshold 1"), (2, "--filter tent --samples 2"),
    (3, "--illumination low --light-rays 1"), (4, "--jitter --threshold 0.9")])
def test_rays_go_between_ranks_and_bits_are_those_of_one_board(tmp_path, ranks, scene):
    assert run(tmp_path, 0, f"{SMALL} {scene} -o one.png").returncode == 0
    done = run(tmp_path, ranks, f"{SMALL} {scene} -o all.png --stats all.json --mpi=rays")
    assert done.returncode == 0, done.stderr
    assert len([line for line in done.stdout.splitlines() if line.startswith("all.png: ")]) == 1, done.stdout
    assert (f"{ranks} hosts: " in done.stdout) == (ranks > 1)
    assert (pixels(tmp_path / "one.png") == pixels(tmp_path / "all.png")).all()
    each = json.loads((tmp_path / "all.json").read_text())["ranks"]["each"]
    assert len(each) == ranks and all(rank["samples"] > 0 and rank["work_ms"] > 0 for rank in each)
    assert (sum(rank["rays_sent"] for rank in each) > 0) == (sum(rank["bytes_sent"] for rank in each) > 0) == (ranks >
        1)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["all.json", "all.png", "one.png"]


def test_ranks_make_an_animation(tmp_path):
    (tmp_path / "turn.scene").write_text(
        'volume { builtin: "buckyball" size: 64 }\ncamera { eye { x: -150 y: -150 z: 20 } }\nimage { width: 32 height: '
        '32 }\n'
        'engine { target: "camera.eye.x" start: -150 rate: 250 }\n')
    done = run(tmp_path, 2, "turn.scene --frames 2 --fps 1 -o a.png --stats a.json --mpi=rays")
    assert done.returncode == 0, done.stderr
    assert (pixels(tmp_path / "a_0000.png") != pixels(tmp_path / "a_0001.png")).any()
    assert len(json.loads((tmp_path / "a.json").read_text())["frames"]) == 2


@pytest.mark.parametrize("arguments, code, text", [
    ("--bogus", 2, "gicube-render: --bogus: no such option"),
    ("--mpi=pictures", 2, 'gicube-render: --mpi: expected rays, a picture with the bits of one board, got "pictures"'),
    ("--crop", 2, "gicube-render: --mpi: expected without --crop"),
    ("--board emu: --board emu: --board emu:", 2,
     "gicube-render: --board: expected one for each of 2 ranks, or one emu: for all, got 3"),
    ("--set asic.processors=-3", 2, "gicube-render: URI options: expected values that gicube-board accepts"),
    ("-o none/picture.png", 1, "gicube-render: none/picture.png: expected a folder that is there, got none"),
])
def test_an_error_of_all_ranks_is_said_once(tmp_path, arguments, code, text):
    done = run(tmp_path, 2, f"{SMALL} {'' if '--mpi' in arguments else '--mpi=rays'} {arguments}")
    said = said_by_program(done.stderr)
    assert done.returncode == code and len(said) == 1 and said[0].startswith(text), done.stderr
    assert not list(tmp_path.iterdir())


def test_each_rank_takes_its_board(tmp_path):
    done = run(tmp_path, 2, f"builtin:buckyball --volume-size 32 --mpi=rays -o a.png --board emu: --board "
                            f"unix:{tmp_path}/none.sock")
    said = said_by_program(done.stderr)
    assert done.returncode == 1 and len(said) == 1 and said[0].startswith(
        "gicube-render: rank 1 of 2: ") and "none.sock" in said[0], done.stderr


def environment(process):
    return dict(entry.split("=", 1) for entry in (process / "environ").read_text().split("\0") if "=" in entry)


def find(name, is_it):
    """The process of that name for which is_it(folder in /proc) is true."""
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if (process / "comm").read_text().strip() == name and is_it(process):
                return int(process.name)
        except OSError:  # it has ended
            pass
    return None


def wait_for(what):
    for _ in range(500):
        if (found := what()) is not None:
            return found
        time.sleep(0.02)
    raise AssertionError("it did not start")


def parent_of(process):
    return int((process / "stat").read_text().rpartition(")")[2].split()[1])


@pytest.mark.parametrize("victim", ["rank", "board"])
def test_a_killed_rank_or_board_ends_the_job(tmp_path, victim):
    job = subprocess.Popen(command(2, f"{LONG} -o picture.png --mpi=rays"), cwd=tmp_path, stdout=subprocess.PIPE,
                           stderr=subprocess.PIPE, text=True)

    def is_rank_1(process):
        return (process / "cwd").resolve() == tmp_path and "1" in (
            environment(process).get(name) for name in ("OMPI_COMM_WORLD_RANK", "PMI_RANK"))
    rank = wait_for(lambda: find("gicube-render", is_rank_1))
    board = wait_for(lambda: find("gicube-board", lambda process: parent_of(process) == rank))
    time.sleep(0.5)
    assert job.poll() is None
    os.kill(rank if victim == "rank" else board, signal.SIGKILL)
    _, error = job.communicate(timeout=60)
    assert job.returncode != 0
    if victim == "board":
        said = said_by_program(error)
        assert len(said) == 1 and said[0].startswith("gicube-render: rank 1 of 2: ") and "the board is lost" in said[
            0], error
    else:
        assert "rank 1" in error or "EXIT CODE: 9" in error, error
    assert not list(tmp_path.iterdir())


def test_without_the_library_its_package_is_named(tmp_path):
    shutil.copy(BIN / "gicube-render", tmp_path)
    done = subprocess.run([tmp_path / "gicube-render", *SMALL.split(), "--mpi=rays"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1, done.stderr
    assert "which the package gicube-mpi has, got: libgicube-mpi.so" in done.stderr, done.stderr
