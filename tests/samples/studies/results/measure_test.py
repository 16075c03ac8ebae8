"""What was measured is kept, and is not measured again."""
import os
import pathlib

import pytest

BIN = pathlib.Path(os.environ["GICUBE_BIN_DIR"])
os.environ["GICUBE_BOARD"] = str(BIN / "gicube-board")

from bench import Bench  # noqa: E402
from measure import kept_in, measure_boards, measure_shard  # noqa: E402

RUN = Bench(32, 8).run("rock")


def boards():
    """Two runs on one board, and one on another."""
    return [[RUN, RUN.at_step(1)], [RUN.on({"link.bits": 64})]]


@pytest.fixture
def no_board(monkeypatch):
    def refuse(run):
        raise AssertionError(f"measured again: {run.name()}")
    monkeypatch.setattr("measure.open_board", refuse)


def measured(folder, jobs=2, pictures=()):
    return dict(measure_boards(kept_in(folder), jobs, dict(pictures), boards()))


def test_results_come_from_the_file_the_next_time(tmp_path, monkeypatch):
    folder, picture = tmp_path / "measured", tmp_path / "rock.png"
    first = measured(folder, pictures={RUN: picture})
    assert picture.read_bytes()[1:4] == b"PNG"
    assert set(first) == {run for each in boards() for run in each}
    assert all(result["counters"]["processor.samples"] > 0 for result in first.values())

    again = []
    monkeypatch.setattr("measure.measure_board", lambda runs, *_: again.append(runs[0]) or [first[run] for run in runs])
    assert measured(folder, pictures={RUN: picture}) == first
    assert not again
    # A file that was cut off is none, and so is one of a run whose picture is gone: it is measured again.
    max(folder.rglob("*.json")).rename(tmp_path / "cut.part")
    assert measured(folder) == first
    assert len(again) == 1
    picture.unlink()
    measured(folder, pictures={RUN: picture})
    assert again[1:] == [RUN]


def test_what_another_board_measured_does_not_count(tmp_path, no_board, monkeypatch):
    kept = kept_in(tmp_path)
    for runs in boards():
        kept.of("\n".join(run.name() for run in runs), lambda runs=runs: [{} for _ in runs])
    assert set(measured(tmp_path, jobs=1)) == {run for each in boards() for run in each}
    another = tmp_path / "gicube-board"
    another.write_text("another")
    monkeypatch.setenv("GICUBE_BOARD", str(another))
    with pytest.raises(AssertionError, match="measured again"):
        measured(tmp_path, jobs=1)


def test_an_error_names_its_run(tmp_path):
    with pytest.raises(RuntimeError, match=r"rock .*asic.queue_rays=-1: "):
        list(measure_boards(kept_in(tmp_path), 1, {}, [[RUN.on({"asic.queue_rays": -1})]]))


def test_each_board_falls_to_one_shard_and_all_come_once_the_others_are_done(tmp_path):
    kept, begun = kept_in(tmp_path), []
    lists = [[RUN.on({"link.bits": bits})] for bits in range(1, 20)]

    def measure(boards):
        for runs in boards:
            begun.append(runs)
            kept.of("\n".join(run.name() for run in runs), lambda: [{}])
            yield runs[0], {}
    first = dict(measure_shard(kept, (1, 2), measure, lists))
    assert 0 < len(first) == len(begun) < len(lists)
    second = dict(measure_shard(kept, (2, 2), measure, lists))
    assert set(second) == {runs[0] for runs in lists}
    mine = begun[len(first):len(lists)]
    assert sorted(run.name() for run, in begun[:len(lists)]) == sorted(run.name() for run,
        in lists), "each began in one shard"
    begun.clear()
    assert dict(measure_shard(kept, (2, 2), measure, lists[::-1])) == second
    assert begun[:len(mine)] == mine[::-1]
