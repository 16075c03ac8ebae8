"""gicube-sweep --shard: parts of a sweep that others put together, as its users run it."""
import os
import pathlib
import subprocess

import pytest

from studies import sweep

SWEEP = pathlib.Path(os.environ["GICUBE_BIN_DIR"]) / "gicube-sweep"
SMALL = "builtin:buckyball --fix volume-size=32 --fix size=24x24 --vary step=0.5,1,2 --reference step=0.25 --quiet"


def run(folder, arguments=""):
    """The keys of the runs that are in the folder afterwards, with their files' time of change."""
    subprocess.run([SWEEP, *SMALL.split(), "-o", folder, *arguments.split()], check=True)
    return {file.name: file.stat().st_mtime_ns for file in (folder / "runs").glob("*.json")}


def test_shards_have_each_run_once_and_the_sweep_after_them_has_nothing_left_to_do(tmp_path):
    whole = run(tmp_path / "whole")
    assert len(whole) == 4
    parts = [run(tmp_path / f"part{i}", f"--shard {i}/3 --chart") for i in (1, 2, 3)]
    assert sorted(len(part) for part in parts) == [1, 1, 2]
    assert sorted(name for part in parts for name in part) == sorted(whole)
    assert not [file for i in (1, 2, 3) for file in (tmp_path / f"part{i}").iterdir() if file.name != "runs"]

    # At the same time in one folder, as a batch system has them.
    shards = [subprocess.Popen([SWEEP, *SMALL.split(), "-o", tmp_path / "shared", "--shard", f"{i}/3"])
              for i in (1, 2, 3)]
    assert [shard.wait() for shard in shards] == [0, 0, 0]
    before = {file.name: file.stat().st_mtime_ns for file in (tmp_path / "shared/runs").glob("*.json")}
    assert run(tmp_path / "shared") == before
    assert (tmp_path / "shared/sweep.csv").read_bytes() == (tmp_path / "whole/sweep.csv").read_bytes()


def test_a_shard_does_not_depend_on_what_is_done(tmp_path):
    first = run(tmp_path, "--shard 1/2")
    assert run(tmp_path, "--shard 1/2") == first
    both = run(tmp_path, "--shard 2/2")
    assert len(both) == 4 and {name: both[name] for name in first} == first


def test_a_shard_beyond_the_runs_does_nothing(tmp_path):
    assert run(tmp_path, "--shard 9/9") == {}


@pytest.mark.parametrize("text", ["", "1", "0/2", "3/2", "1/0", "-1/2", "1/2/3", "a/b", "1.0/2", "1/1234567"])
def test_what_is_no_shard_is_refused(text):
    with pytest.raises(sweep.argparse.ArgumentTypeError, match="expected I/N"):
        sweep.shard_of(text)
