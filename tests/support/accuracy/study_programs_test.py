"""The programs that script/charts measures with, as it runs them."""
import os
import subprocess

import pytest

from studies.pictures import read_picture, rmse

BIN = os.environ["GICUBE_BIN_DIR"]
BALL = "builtin:buckyball --volume-size 32 --size 40x30"


@pytest.fixture
def run(tmp_path):
    """Of the programs beside the tests, or those of the product."""
    def of(program, arguments, folder=f"{BIN}/../tests"):
        return subprocess.run([f"{folder}/{program}", *arguments.split()], cwd=tmp_path, capture_output=True, text=True,
                              check=False)
    return of


def test_the_reference_draws_what_the_board_draws(run, tmp_path):
    exact = run("gicube-reference", f"{BALL} -o exact.exr")
    assert exact.returncode == 0, exact.stderr
    assert run("gicube-render", f"{BALL} --quiet --no-leap -o board.exr", BIN).returncode == 0
    assert run("gicube-render", f"{BALL} --quiet --eye 60,60,60 -o other.exr", BIN).returncode == 0
    reference = read_picture(tmp_path / "exact.exr")
    assert reference.shape == (30, 40, 4)
    assert rmse(read_picture(tmp_path / "board.exr"), reference) < 0.01  # 40 dB
    assert rmse(read_picture(tmp_path / "other.exr"), reference) > 0.05


def test_the_reference_names_what_it_cannot_write(run):
    result = run("gicube-reference", f"{BALL} -o /nowhere/exact.exr")
    assert result.returncode != 0 and "/nowhere/exact.exr" in result.stderr
