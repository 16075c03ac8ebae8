"""What was measured is kept, and is not measured again."""
import os
import pathlib

import pytest

BIN = pathlib.Path(os.environ["GICUBE_BIN_DIR"])
os.environ["GICUBE_BOARD"] = str(BIN / "gicube-board")

from bench import Bench  # noqa: E402
from measure import Store  # noqa: E402

RUN = Bench(32, 8).run("rock")


def boards():
    """Two runs on one board, and one on another."""
    return [[RUN, RUN.at_step(1)], [RUN.on({"link.bits": 64})]]


@pytest.fixture
def no_board(monkeypatch):
    def refuse(run):
        raise AssertionError(f"measured again: {run.name()}")
    monkeypatch.setattr("measure.open_board", refuse)


def measured(store, jobs=2, pictures=()):
    return dict(store.measure(boards(), jobs, dict(pictures)))


def test_results_come_from_the_file_the_next_time(tmp_path, monkeypatch):
    path, picture = tmp_path / "measured.jsonl", tmp_path / "rock.png"
    first = measured(Store(path), pictures={RUN: picture})
    assert picture.read_bytes()[1:4] == b"PNG"
    assert set(first) == {run for each in boards() for run in each}
    assert all(result["counters"]["processor.samples"] > 0 for result in first.values())

    again = []
    monkeypatch.setattr("measure.measure_board", lambda runs, *_: again.append(runs[0]) or [first[run] for run in runs])
    assert measured(Store(path), pictures={RUN: picture}) == first
    assert not again
    # A line that was cut off is measured again, and so is a run whose picture is gone.
    path.write_text("\n".join(path.read_text().splitlines()[:2]) + '\n[["rock st')
    assert measured(Store(path)) == first
    assert len(again) == 1
    picture.unlink()
    measured(Store(path), pictures={RUN: picture})
    assert again[1:] == [RUN]


def test_what_another_board_measured_does_not_count(tmp_path, no_board):
    path = tmp_path / "measured.jsonl"
    path.write_text("another\n[[],[]]\n")
    with pytest.raises(AssertionError, match="measured again"):
        measured(Store(path), jobs=1)


def test_an_error_names_its_run(tmp_path):
    store = Store(tmp_path / "measured.jsonl")
    with pytest.raises(RuntimeError, match=r"rock .*asic.queue_rays=-1: "):
        list(store.measure([[RUN.on({"asic.queue_rays": -1})]], 1, {}))
