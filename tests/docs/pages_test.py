"""The listings of the guide's pages on errors, C and the upgrade: compiled against the public headers alone, run, and
compared with the output that the page shows."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from listings import ROOT, listings

BUILD = Path(os.environ["GICUBE_BUILD"])
LINK = [f"-I{ROOT}/driver/include", f"-L{BUILD}/lib", f"-Wl,-rpath,{BUILD}/lib"]


def output_of(*command, cwd):
    done = subprocess.run([str(each) for each in command], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def files(request, tmp_path):
    """A page's files, written to the test's folder."""
    found = listings(request.param)
    for name, text in found.items():
        (tmp_path / name).write_text(text)
    return found


def program(source, folder):
    compiler = ["cc", "-std=c99", "-Wpedantic"] if source.endswith(".c") else ["c++", "-std=c++20"]
    output_of(*compiler, "-Wall", "-Wextra", "-Werror", *LINK, source, "-lgicube", "-o", "program", cwd=folder)
    return folder / "program"


@pytest.mark.parametrize("files", ["docs/guide/errors.md"], indirect=True)
@pytest.mark.parametrize("language", ["cpp", "python"])
def test_errors(files, language, tmp_path):
    command = [program("errors.cpp", tmp_path)] if language == "cpp" else [sys.executable, "errors.py"]
    assert output_of(*command, cwd=tmp_path) == files["output"]
    assert output_of(*command, "emu:?faults=plan.textproto", cwd=tmp_path) == files["plan.output"] + files["output"]


@pytest.mark.parametrize("files", ["docs/guide/c.md"], indirect=True)
def test_c(files, tmp_path):
    from OpenImageIO import UINT8, ImageBuf

    assert output_of(program("cube.c", tmp_path), cwd=tmp_path) == files["output"]
    made, shown = (
        ImageBuf(str(file)).get_pixels(UINT8) for file in (tmp_path / "cube.ppm", ROOT / "docs/pictures/c_cube.png")
    )
    assert np.array_equal(made, shown)


@pytest.mark.parametrize("files", ["docs/guide/upgrade.md"], indirect=True)
def test_upgrade(files, tmp_path):
    assert output_of(program("upgrade.cpp", tmp_path), cwd=tmp_path) == files["output"]
