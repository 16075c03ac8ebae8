"""The listings of docs/guide/tutorial.md run: the C++ program and the Python program print what the page says and make
the same pictures, and those are the page's. Its tests pass. The C++ listings see an installed SDK and nothing else.

If a picture is to change, copy it from the folder that the failure names.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from listings import ROOT, listings

PAGE = "docs/guide/tutorial.md"
PICTURES = ROOT / "docs/pictures/tutorial"
LISTINGS = listings(PAGE)
SHOWN = sorted(set(re.findall(r"\(\.\./pictures/tutorial/(\w+\.png)\)", (ROOT / PAGE).read_text())))


def run(*command, cwd, **environment):
    done = subprocess.run(
        [str(each) for each in command], cwd=cwd, env={**os.environ, **environment}, capture_output=True, text=True
    )
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}{done.stderr}"
    return done.stdout


@pytest.fixture(scope="module")
def sdk(tmp_path_factory):
    """An installed SDK, and the environment of programs that use it."""
    prefix = tmp_path_factory.mktemp("sdk")
    for component in ("runtime", "dev"):
        run(
            "cmake", "--install", os.environ["GICUBE_BUILD"], "--prefix", prefix, "--component", component, cwd=prefix
        )
    return prefix


@pytest.fixture(scope="module")
def scans(tmp_path_factory):
    """What step 9 makes if no scan is at hand."""
    folder = tmp_path_factory.mktemp("scans")
    run(sys.executable, ROOT / "samples/python/phantoms.py", folder, cwd=folder)
    return folder


def pixels_of(file):
    """What a PNG holds, whatever wrote it."""
    from OpenImageIO import UINT8, ImageBuf

    return ImageBuf(str(file)).get_pixels(UINT8)


def check(folder, printed):
    assert printed == LISTINGS["output"]
    for name in SHOWN:
        assert np.array_equal(
            pixels_of(folder / name), pixels_of(PICTURES / name)
        ), f"{folder / name} is not the page's"


def test_the_page_shows_a_picture_of_each_step():
    assert len(SHOWN) == 8 and len(re.findall(r"^!\[", (ROOT / PAGE).read_text(), re.MULTILINE)) == 10


def test_the_program_in_cpp(sdk, scans, tmp_path):
    source = tmp_path / "tutorial.cpp"
    source.write_text(LISTINGS["tutorial.cpp"])
    (tmp_path / "ct_head.nrrd").symlink_to(scans / "ct_head.nrrd")
    flags = [
        "-std=c++20",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Werror",
        f"-I{sdk}/include",
        f"-L{sdk}/lib",
        f"-Wl,-rpath,{sdk}/lib",
    ]
    run("c++", *flags, source, "-lgicube", "-lgicube-scene", "-o", tmp_path / "tutorial", cwd=tmp_path)
    check(tmp_path, run(tmp_path / "tutorial", cwd=tmp_path))


def test_the_program_in_python(scans, tmp_path):
    (tmp_path / "tutorial.py").write_text(LISTINGS["tutorial.py"])
    (tmp_path / "ct_head.nrrd").symlink_to(scans / "ct_head.nrrd")
    check(tmp_path, run(sys.executable, "tutorial.py", cwd=tmp_path, MPLBACKEND="Agg"))
    assert (tmp_path / "cycles.svg").stat().st_size > 1000


def test_the_test_in_cpp(sdk, tmp_path):
    for name in ("CMakeLists.txt", "preview_test.cpp"):
        (tmp_path / name).write_text(LISTINGS[name])
    run("cmake", "-G", "Ninja", "-S", tmp_path, "-B", tmp_path / "build", f"-DCMAKE_PREFIX_PATH={sdk}", cwd=tmp_path)
    run("cmake", "--build", tmp_path / "build", cwd=tmp_path)
    said = run("ctest", "--test-dir", tmp_path / "build", cwd=tmp_path)
    assert "100% tests passed, 0 tests failed out of 2" in said, said


def test_the_test_in_python(tmp_path):
    (tmp_path / "preview_test.py").write_text(LISTINGS["preview_test.py"])
    said = run(sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "preview_test.py", cwd=tmp_path)
    assert "2 passed" in said, said
